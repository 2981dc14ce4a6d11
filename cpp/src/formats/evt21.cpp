#include "asap/formats/prophesee.hpp"

#include <bit>

#include "formats/words.hpp"

namespace asap::inline v0_1 {

namespace {

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

std::size_t Evt21Decoder::decode_words(const std::byte* first, std::size_t count,
                                       Output& out) noexcept {
  return config_.little_endian ? decode_in_order<true>(first, count, out)
                               : decode_in_order<false>(first, count, out);
}

template <bool kLittleEndian>
std::size_t Evt21Decoder::decode_in_order(const std::byte* first, std::size_t count,
                                          Output& out) noexcept {
  std::size_t i = 0;
  while (i < count) {
    const std::size_t safe = started_ ? out.room() / kMaxPerRecord : 0;
    const std::size_t end = i + std::min(count - i, safe);
    Event* event = out.event;
    const std::int64_t high = high_;
    for (; i < end; ++i) {
      const std::uint64_t word = evt21_word<kLittleEndian>(first, i);
      if (word >> 61 != 0) break;
      event = write_events(event, word, high);
    }
    out.event = event;
    if (i == count) break;
    const std::uint64_t word = evt21_word<kLittleEndian>(first, i);
    if (!decode_any(word, offset_ + i * sizeof(std::uint64_t), out)) break;
    ++i;
  }
  return i;
}

// False without room for it.
bool Evt21Decoder::decode_any(std::uint64_t word, std::uint64_t offset, Output& out) noexcept {
  if (word >> 61 != 0) return decode_other(static_cast<std::uint32_t>(word >> 32), offset, out);
  const auto count = static_cast<std::size_t>(std::popcount(static_cast<std::uint32_t>(word)));
  if (!started_) {
    before_start_ += count;
    return true;
  }
  if (count > out.room()) return false;
  if (count > 0) out.event = write_events(out.event, word, high_);
  return true;
}

template class NativeDecoder<Evt21Decoder, Evt21Config, 8>;

}  // namespace asap::inline v0_1
