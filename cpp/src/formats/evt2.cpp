#include "asap/formats/evt2.hpp"

#include "formats/words.hpp"

namespace asap {

namespace {

enum Evt2Type : std::uint32_t { kEvt2TimeHigh = 8, kEvt2Trigger = 10, kEvt2Others = 14 };

constexpr std::int64_t kEvt2Range = std::int64_t{1} << 34;  // us

}  // namespace

Progress Evt2Decoder::decode(std::span<const std::byte> bytes, std::span<Event> events) noexcept {
  return decode(bytes, output_to(events));
}

Progress Evt2Decoder::decode(std::span<const std::byte> bytes, std::span<Event> events,
                             std::span<Trigger> triggers) noexcept {
  return decode(bytes, output_to(events, triggers));
}

Progress Evt2Decoder::decode(std::span<const std::byte> bytes, const Output& out) noexcept {
  return decode_stream(state_.cut, state_.offset, bytes, out,
                       [this](const std::byte* at, std::size_t count, Output& to) {
                         return decode_words(at, count, to);
                       });
}

std::size_t Evt2Decoder::decode_words(const std::byte* first, std::size_t count,
                                      Output& out) noexcept {
  std::size_t i = 0;
  while (i < count) {
    // Every word is written as if it were an event; one that is none is overwritten by the next.
    const std::size_t end = state_.started ? i + std::min(count - i, out.room()) : i;
    Event* event = out.event;
    const std::int64_t high = state_.high;
    for (; i < end; ++i) {
      const auto word = load_little<std::uint32_t>(first + i * sizeof(std::uint32_t));
      if (word >> 29 != 0) break;
      write_event(event++, word >> 11 & 0x7ff, word & 0x7ff, word >> 28,
                  high + (word >> 22 & 0x3f));
    }
    out.event = event;
    if (i == count) break;
    const auto word = load_little<std::uint32_t>(first + i * sizeof(std::uint32_t));
    if (!decode_other(word, state_.offset + i * sizeof(std::uint32_t), out)) break;
    ++i;
  }
  return i;
}

// Any word; false without room for it.
bool Evt2Decoder::decode_other(std::uint32_t word, std::uint64_t offset, Output& out) noexcept {
  const std::uint32_t type = word >> 28;
  if (type <= 1) {
    if (state_.started) return false;
    ++state_.before_start;
  } else if (type == kEvt2TimeHigh) {
    state_.high = unwrapped(state_.high, std::int64_t{word & 0xfffffff} << 6, kEvt2Range);
    state_.started = true;
  } else if (type == kEvt2Trigger) {
    const Trigger trigger{.t = state_.high + (word >> 22 & 0x3f),
                          .id = static_cast<std::uint16_t>(word >> 8 & 0x1f),
                          .value = static_cast<std::uint16_t>(word & 1)};
    if (state_.started && !out.take(trigger)) return false;
    ++state_.triggers;
  } else if (type < kEvt2Others) {
    state_.bad.add(offset);
  }
  return true;
}

}  // namespace asap
