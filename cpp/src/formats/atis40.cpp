#include "asap/formats/atis.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include "formats/opener.hpp"
#include "formats/records.hpp"
#include "formats/words.hpp"

namespace asap::inline v0_1 {

namespace {

// A record is the upper 40 bits of a word.
struct Atis40 {
  static constexpr std::size_t kRecord = 5;
  static constexpr bool kBigEndian = true;
  static constexpr std::uint64_t kMarkRow = 240;
  static constexpr std::int64_t kMarkUs = 1 << 13;

  std::uint64_t mark_row;  // beyond 8 bits: none
  std::int64_t marked_us;

  static bool waits(std::uint64_t, const Output&) noexcept { return false; }
  static std::size_t size(std::uint64_t) noexcept { return kRecord; }
  bool is_event(std::uint64_t word) const noexcept { return (word >> 48 & 0xff) != mark_row; }
  std::size_t take(std::uint64_t word, Event* to, Output&) noexcept {
    const bool event = is_event(word);
    marked_us += event ? 0 : kMarkUs;
    write_event(to, word >> 56, word >> 48 & 0xff, word >> 47 & 1,
                static_cast<std::int64_t>(word >> 24 & 0x7f'ffff) + marked_us);
    return event;
  }
};

}  // namespace

std::size_t Atis40Decoder::decode_bytes(std::span<const std::byte> bytes, Output& out) noexcept {
  Atis40 format{config_.marks ? Atis40::kMarkRow : ~std::uint64_t{0}, marked_us_};
  const std::size_t used = records::decode_records(format, cut_, bytes, out);
  marked_us_ = format.marked_us;
  return used;
}

// Nothing in such bytes says it: the name of the file or the user does.
bool Atis40Decoder::begins(std::span<const std::byte>) noexcept { return false; }

// Says what speaks against 40-bit events: length, times, rows.
OpenedRecording Atis40Decoder::open(const RecordingFile& file) {
  constexpr std::size_t kMinBack = 8;  // steps back in time, and a quarter of all: no recording
  std::vector<Event> events;
  Atis40Decoder().decode(file.front, events);
  std::size_t back = 0;
  for (std::size_t i = 1; i < events.size(); ++i) back += events[i].t < events[i - 1].t;
  const auto below =
      std::ranges::count_if(events, [](const Event& event) { return event.y >= Atis40::kMarkRow; });
  const std::string count = std::to_string(events.size());
  if (back > std::max(events.size() / 4, kMinBack)) {
    file.corrupt("no 40-bit events: the time goes back " + std::to_string(back) + " times in " +
                 count + "; if it is another format, name it with file_format");
  }
  constexpr const char* kDoubted = "40-bit events, which nothing in such a file confirms, but ";
  std::string doubt;
  const auto add = [&](bool doubtful, const std::string& words) {
    if (doubtful) doubt += (doubt.empty() ? kDoubted : " and ") + words;
  };
  add(file.size % Atis40::kRecord != 0,
      "its " + std::to_string(file.size) + " bytes are no multiple of 5");
  add(back * 20 > events.size(),
      "the time goes back " + std::to_string(back) + " times in " + count + " events");
  add(below > 0, std::to_string(below) + " of " + count + " events lie below its 240 rows");
  return {.event_bytes = Atis40::kRecord, .doubt = doubt, .make = [](std::uint64_t, std::size_t) {
            return Atis40Decoder();
          }};
}

template class NativeDecoder<Atis40Decoder, Atis40Config, 5>;

}  // namespace asap::inline v0_1
