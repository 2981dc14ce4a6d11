#include "asap/formats/atis.hpp"

#include "formats/records.hpp"
#include "formats/words.hpp"

namespace asap {

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

template class NativeDecoder<Atis40Decoder, Atis40Config, 5>;

}  // namespace asap
