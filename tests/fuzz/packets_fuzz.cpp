// MonoDecoder, LibcaerDecoder, LibcaerCmpDecoder, DvsRecords: any bytes as a few messages. How they
// are cut and how much room there is makes no difference; every record is events or counted.
#include <algorithm>
#include <vector>

#include "asap/formats/packets.hpp"
#include "bytes.hpp"

using namespace asap;

namespace {

// Exactly the room that is promised to be enough: the sanitizer sees a write beyond it.
template <class Decoder>
void feed(Decoder& decoder, std::span<const std::byte> bytes, std::size_t piece, std::size_t room,
          std::vector<Event>& events) {
  while (!bytes.empty()) {
    std::vector<Event> some(room);
    const Progress progress = decoder.decode(bytes.first(std::min(piece, bytes.size())), some);
    fuzz::check(progress.bytes > 0 || progress.events > 0);
    events.insert(events.end(), some.begin(),
                  some.begin() + static_cast<std::ptrdiff_t>(progress.events));
    bytes = bytes.subspan(progress.bytes);
  }
}

template <class Decoder>
void check_decoder(fuzz::Bytes& bytes) {
  const PacketConfig config{.first_offset = bytes.below(100)};
  const std::size_t piece = 1 + bytes.below(64);
  const std::size_t room = Decoder::kMostPerRecord + bytes.below(64);
  Decoder whole(config), cut(config);
  std::vector<Event> events, same;
  std::size_t fed = 0;
  while (!bytes.empty()) {
    const auto base = bytes.take<std::uint64_t>();
    const std::size_t size = bytes.below(512);
    const auto rest = std::as_bytes(bytes.rest());
    const auto message = rest.first(std::min(rest.size(), size));
    for (std::size_t i = 0; i < message.size(); ++i) bytes.take<std::uint8_t>();
    fed += message.size();
    whole.begin(base);
    cut.begin(base);
    feed(whole, message, message.size(), 8 * message.size() + Decoder::kMostPerRecord, events);
    feed(cut, message, piece, room, same);
    fuzz::check(whole.unfinished() == cut.unfinished());
  }
  fuzz::check(events == same && whole.bad_records() == cut.bad_records());
  fuzz::check(std::ranges::equal(whole.noted(), cut.noted()));
  fuzz::check(
      std::ranges::all_of(whole.noted(), [&](auto at) { return at < config.first_offset + fed; }));
}

void check_records(fuzz::Bytes& bytes) {
  const auto layout = bytes.flag() ? DvsRecords::Layout::ros1 : DvsRecords::Layout::cdr;
  const std::size_t piece = 1 + bytes.below(64);
  const auto rest = bytes.rest();
  const std::vector<std::uint8_t> copy(rest.begin(), rest.end());  // its end is watched
  const DvsRecords records(std::as_bytes(std::span(copy)), layout);
  std::vector<Event> events(records.whole()), same;
  records.decode(0, events);
  for (std::size_t at = 0; at < events.size(); at += piece) {
    std::vector<Event> some(std::min(piece, events.size() - at));
    records.decode(at, some);
    same.insert(same.end(), some.begin(), some.end());
  }
  fuzz::check(events == same);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Bytes bytes(data, size);
  switch (bytes.below(4)) {
    case 0:
      check_decoder<MonoDecoder>(bytes);
      break;
    case 1:
      check_decoder<LibcaerDecoder>(bytes);
      break;
    case 2:
      check_decoder<LibcaerCmpDecoder>(bytes);
      break;
    default:
      check_records(bytes);
  }
  return 0;
}
