#include "asap/formats/prophesee.hpp"

#include "formats/words.hpp"

namespace asap::inline v0_1 {

namespace {

enum Evt2Type : std::uint32_t { kEvt2TimeHigh = 8, kEvt2Trigger = 10, kEvt2Others = 14 };

constexpr std::uint32_t kEvt2Padding = 0x9999'9999;         // as in EVT3
constexpr std::int64_t kEvt2Range = std::int64_t{1} << 34;  // us

}  // namespace

std::size_t Evt2Decoder::decode_words(const std::byte* first, std::size_t count,
                                      Output& out) noexcept {
  std::size_t i = 0;
  while (i < count) {
    // Every word is written as if it were an event; one that is none is overwritten by the next.
    const std::size_t end = started_ ? i + std::min(count - i, out.room()) : i;
    Event* event = out.event;
    const std::int64_t high = high_;
    for (; i < end; ++i) {
      const auto word = load_little<std::uint32_t>(first + i * sizeof(std::uint32_t));
      if (word >> 29 != 0) break;
      write_event(event++, word >> 11 & 0x7ff, word & 0x7ff, word >> 28,
                  high + (word >> 22 & 0x3f));
    }
    out.event = event;
    if (i == count) break;
    const auto word = load_little<std::uint32_t>(first + i * sizeof(std::uint32_t));
    if (word >> 29 == 0) {
      if (started_) break;  // no room
      ++before_start_;
    } else if (!decode_other(word, offset_ + i * sizeof(std::uint32_t), out)) {
      break;
    }
    ++i;
  }
  return i;
}

template <class Decoder, class Config, std::size_t kRecord>
bool Evt2Words<Decoder, Config, kRecord>::decode_other(std::uint32_t word, std::uint64_t offset,
                                                       Output& out) noexcept {
  const std::uint32_t type = word >> 28;
  if (type == kEvt2TimeHigh) {
    high_ = unwrapped(high_, std::int64_t{word & 0xfffffff} << 6, kEvt2Range);
    started_ = true;
  } else if (type == kEvt2Trigger) {
    const Trigger trigger{.t = high_ + (word >> 22 & 0x3f),
                          .id = static_cast<std::uint16_t>(word >> 8 & 0x1f),
                          .value = static_cast<std::uint16_t>(word & 1)};
    if (started_ && !out.take(trigger)) return false;
    ++this->triggers_;
  } else if (type < kEvt2Others && word != kEvt2Padding) {
    this->bad_.add(offset);
  }
  return true;
}

template class NativeDecoder<Evt2Decoder, Evt2Config, 4>;
template class Evt2Words<Evt2Decoder, Evt2Config, 4>;
template class Evt2Words<Evt21Decoder, Evt21Config, 8>;

}  // namespace asap::inline v0_1
