#include "asap/formats/evt21.hpp"

#include <bit>

#include "formats/words.hpp"

namespace asap {

namespace {

enum Evt21Type : std::uint64_t { kEvt21TimeHigh = 8, kEvt21Trigger = 10, kEvt21Others = 14 };

constexpr std::int64_t kEvt21Range = std::int64_t{1} << 34;  // us

template <bool kLittleEndian>
std::uint64_t evt21_word(const std::byte* first, std::size_t i) noexcept {
  const auto word = load_little<std::uint64_t>(first + i * sizeof(std::uint64_t));
  return kLittleEndian ? word : std::rotl(word, 32);
}

// The events of an ON or OFF word. Writes one at least, which counts only if there is one.
Event* write_events(Event* out, std::uint64_t word, std::int64_t high) noexcept {
  const std::uint64_t x = word >> 43 & 0x7ff, y = word >> 32 & 0x7ff, p = word >> 60;
  const std::int64_t t = high + static_cast<std::int64_t>(word >> 54 & 0x3f);
  auto mask = static_cast<std::uint32_t>(word);
  const std::size_t some = mask != 0;
  do {
    write_event(out, x + static_cast<std::uint64_t>(std::countr_zero(mask)), y, p, t);
    out += some;
    mask &= mask - 1;
  } while (mask != 0);
  return out;
}

}  // namespace

Progress Evt21Decoder::decode(std::span<const std::byte> bytes, std::span<Event> events) noexcept {
  return decode(bytes, output_to(events));
}

Progress Evt21Decoder::decode(std::span<const std::byte> bytes, std::span<Event> events,
                              std::span<Trigger> triggers) noexcept {
  return decode(bytes, output_to(events, triggers));
}

Progress Evt21Decoder::decode(std::span<const std::byte> bytes, const Output& out) noexcept {
  return decode_stream(state_.cut, state_.offset, bytes, out,
                       [this](const std::byte* at, std::size_t count, Output& to) {
                         return config_.little_endian ? decode_words<true>(at, count, to)
                                                      : decode_words<false>(at, count, to);
                       });
}

template <bool kLittleEndian>
std::size_t Evt21Decoder::decode_words(const std::byte* first, std::size_t count,
                                       Output& out) noexcept {
  std::size_t i = 0;
  while (i < count) {
    const std::size_t safe = state_.started ? out.room() / kMostPerRecord : 0;
    const std::size_t end = i + std::min(count - i, safe);
    Event* event = out.event;
    const std::int64_t high = state_.high;
    for (; i < end; ++i) {
      const std::uint64_t word = evt21_word<kLittleEndian>(first, i);
      if (word >> 61 != 0) break;
      event = write_events(event, word, high);
    }
    out.event = event;
    if (i == count) break;
    const std::uint64_t word = evt21_word<kLittleEndian>(first, i);
    if (!decode_any(word, state_.offset + i * sizeof(std::uint64_t), out)) break;
    ++i;
  }
  return i;
}

// False without room for it.
bool Evt21Decoder::decode_any(std::uint64_t word, std::uint64_t offset, Output& out) noexcept {
  const std::uint64_t type = word >> 60;
  if (type <= 1) {
    const auto count = static_cast<std::size_t>(std::popcount(static_cast<std::uint32_t>(word)));
    if (!state_.started) {
      state_.before_start += count;
      return true;
    }
    if (count > out.room()) return false;
    if (count > 0) out.event = write_events(out.event, word, state_.high);
  } else if (type == kEvt21TimeHigh) {
    const auto high = static_cast<std::int64_t>(word >> 32 & 0xfffffff) << 6;
    state_.high = unwrapped(state_.high, high, kEvt21Range);
    state_.started = true;
  } else if (type == kEvt21Trigger) {
    const Trigger trigger{.t = state_.high + static_cast<std::int64_t>(word >> 54 & 0x3f),
                          .id = static_cast<std::uint16_t>(word >> 40 & 0x1f),
                          .value = static_cast<std::uint16_t>(word >> 32 & 1)};
    if (state_.started && !out.take(trigger)) return false;
    ++state_.triggers;
  } else if (type < kEvt21Others) {
    state_.bad.add(offset);
  }
  return true;
}

}  // namespace asap
