// decode_plain is the specification, a word at a time. decode_fast is the loop for the words that
// come often; a test holds it to the same events.
#include "asap/formats/prophesee.hpp"

#include <array>
#include <bit>

#include "formats/words.hpp"

namespace asap::inline v0_1 {

namespace {

enum Evt3Type : std::uint32_t {
  kAddrY = 0,
  kAddrX = 2,
  kVectBase = 3,
  kVect12 = 4,
  kVect8 = 5,
  kTimeLow = 6,
  kContinued4 = 7,
  kTimeHigh = 8,
  kEvt3Trigger = 10,
  kEvt3Others = 14,
  kContinued12 = 15
};

constexpr std::int64_t kEvt3Range = std::int64_t{1} << 24;  // us
constexpr std::uint32_t kEvt3Address = 0x7ff;

constexpr std::uint32_t set_of(auto... types) noexcept { return ((1u << types) | ...); }

// They change the state by one field or give one event.
constexpr std::uint32_t kSimple = set_of(kAddrY, kAddrX, kTimeLow);
constexpr std::uint32_t kKnown =
    kSimple | set_of(kVectBase, kVect12, kVect8, kContinued4, kTimeHigh, kEvt3Trigger, kEvt3Others,
                     kContinued12);

// What a simple word does: the bits of it that become y and TIME_LOW, and the events it gives.
struct Effect {
  std::uint32_t y, low, events;
};

constexpr auto kEffects = [] {
  std::array<Effect, 16> effects{};
  effects[kAddrY].y = kEvt3Address;
  effects[kTimeLow].low = 0xfff;
  effects[kAddrX].events = 1;
  return effects;
}();

// What cameras of GigE fill their packets up with; no word of another kind is like it.
constexpr std::uint32_t kPadding = 0x9999;

std::uint32_t evt3_word(const std::byte* first, std::size_t i) noexcept {
  return load_little<std::uint16_t>(first + i * sizeof(std::uint16_t));
}

std::uint32_t vector_mask(std::uint32_t word) noexcept {
  return word & (word >> 12 == kVect12 ? 0xfff : 0xff);
}

std::uint32_t moved_base(std::uint32_t base, std::uint32_t word) noexcept {
  return (base & 0x10000) | ((base + (word >> 12 == kVect12 ? 12 : 8)) & 0xffff);
}

// The events of a vector. `base` holds x in its lower 16 bits and p above.
Event* write_vector(Event* out, std::uint32_t word, std::uint32_t base, std::uint32_t y,
                    std::int64_t t) noexcept {
  for (std::uint32_t mask = vector_mask(word); mask != 0; mask &= mask - 1) {
    const std::uint32_t x = base + static_cast<std::uint32_t>(std::countr_zero(mask));
    write_event(out++, x & 0xffff, y, base >> 16, t);
  }
  return out;
}

}  // namespace

// Takes one word of any type. False without room for what it gives: it was not taken.
bool Evt3Decoder::decode_plain(std::uint32_t word, std::uint64_t offset, Output& out) noexcept {
  const std::uint32_t type = word >> 12;
  const bool has_time = high_word_ != 0 && has_low_;
  if (type == kAddrY) {
    y_ = word & kEvt3Address;
    has_y_ = true;
  } else if (type == kAddrX) {
    if (!has_time || !has_y_) {
      ++before_start_;
    } else if (out.room() == 0) {
      return false;
    } else {
      write_event(out.event++, word & kEvt3Address, y_, word >> 11 & 1, t_);
    }
  } else if (type == kVectBase) {
    base_ = (word & kEvt3Address) | (word << 5 & 0x10000);
    has_base_ = true;
  } else if (type == kVect12 || type == kVect8) {
    const auto count = static_cast<std::size_t>(std::popcount(vector_mask(word)));
    if (!has_time || !has_y_ || !has_base_) {
      before_start_ += count;
    } else if (count > out.room()) {
      return false;
    } else {
      out.event = write_vector(out.event, word, base_, y_, t_);
    }
    base_ = moved_base(base_, word);
  } else if (type == kTimeLow) {
    t_ = high_ + (word & 0xfff);
    has_low_ = has_low_ || high_word_ != 0;
  } else if (type == kTimeHigh) {
    take_time_high(word);
  } else if (type == kEvt3Trigger) {
    const Trigger trigger{.t = t_,
                          .id = static_cast<std::uint16_t>(word >> 8 & 0xf),
                          .value = static_cast<std::uint16_t>(word & 1)};
    if (has_time && !out.take(trigger)) return false;
    ++triggers_;
  } else if ((kKnown >> type & 1) == 0 && word != kPadding) {
    bad_.add(offset);
  }
  return true;
}

void Evt3Decoder::take_time_high(std::uint32_t word) noexcept {
  if (word == high_word_) return;
  high_ = unwrapped(high_, std::int64_t{word & 0xfff} << 12, kEvt3Range);
  t_ = high_;
  has_low_ = has_low_ || high_word_ != 0;
  high_word_ = word;
}

std::size_t Evt3Decoder::decode_words(const std::byte* first, std::size_t count,
                                      Output& out) noexcept {
  std::size_t i = 0;
  while (i < count) {
    const bool knows_all = high_word_ != 0 && has_low_ && has_y_;
    const std::size_t safe = knows_all ? out.room() / kMaxPerRecord : 0;
    i = decode_fast(first, i, i + std::min(count - i, safe), out);
    if (i == count) break;
    if (!decode_plain(evt3_word(first, i), offset_ + i * sizeof(std::uint16_t), out)) break;
    ++i;
  }
  return i;
}

// Decodes up to `end` or a rare word. The caller knows time and row and has room for a vector per
// word.
std::size_t Evt3Decoder::decode_fast(const std::byte* first, std::size_t i, std::size_t end,
                                     Output& out) noexcept {
  Event* event = out.event;
  const std::int64_t high = high_;
  auto low = static_cast<std::uint32_t>(t_ - high);
  std::uint32_t y = y_, base = base_;
  const std::uint32_t repeated = high_word_;
  const bool has_base = has_base_;
  for (; i < end; ++i) {
    const std::uint32_t word = evt3_word(first, i);
    const std::uint32_t type = word >> 12;
    if ((kSimple >> type & 1) != 0 || word == repeated) {
      // Masks instead of branches, which would be mispredicted: any word is written as an event.
      const Effect effect = kEffects[type];
      y = (word & effect.y) | (y & ~effect.y);
      low = (word & effect.low) | (low & ~effect.low);
      write_event(event, word & kEvt3Address, y, word >> 11 & 1, high + low);
      event += effect.events;
    } else if (!has_base) {
      break;
    } else if (type == kVectBase) {
      base = (word & kEvt3Address) | (word << 5 & 0x10000);
    } else if (type == kVect12 || type == kVect8) {
      event = write_vector(event, word, base, y, high + low);
      base = moved_base(base, word);
    } else {
      break;
    }
  }
  out.event = event;
  t_ = high + low;
  y_ = y;
  base_ = base;
  return i;
}

template class NativeDecoder<Evt3Decoder, Evt3Config, 2>;

}  // namespace asap::inline v0_1
