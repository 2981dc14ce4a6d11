// Evt2Decoder: events of a Prophesee EVT2 stream, 32-bit little-endian words.
//
// Type in bits 31:28: 0 OFF and 1 ON with t 27:22, x 21:11, y 10:0; 8 TIME_HIGH with t >> 6 in
// 27:0, often repeated; 10 external trigger with t 27:22, id 12:8, value 0; 14 and 15 others.
// Times unwrap every 2^34 us, where TIME_HIGH falls by more than half its range. Events before the
// first TIME_HIGH are dropped: their time is unknown.
//
// One thread. Never throws, never allocates. O(bytes).
#pragma once

#include "asap/core/event.hpp"
#include "asap/formats/progress.hpp"

namespace asap {

struct Evt2Config {
  std::uint64_t first_offset = 0;  // offset in the file of the first byte that is fed
};

// What EVT2 shares with EVT2.1, whose upper 32 bits are laid out alike: time and rare words.
template <class Decoder, class Config, std::size_t kRecord>
class Evt2Words : public NativeDecoder<Decoder, Config, kRecord> {
 protected:
  using NativeDecoder<Decoder, Config, kRecord>::NativeDecoder;

  // Any word that is no event; false without room for it.
  bool decode_other(std::uint32_t word, std::uint64_t offset, Output& out) noexcept;

  std::int64_t high_ = 0;  // us, of the last TIME_HIGH, unwrapped
  bool started_ = false;   // a TIME_HIGH came
};

class Evt2Decoder : public Evt2Words<Evt2Decoder, Evt2Config, 4> {
 public:
  static constexpr std::size_t kMostPerRecord = 1;  // events that one word can give

  explicit Evt2Decoder(Evt2Config config = {}) noexcept : Evt2Words(config, config.first_offset) {}

 private:
  friend NativeDecoder;

  std::size_t decode_words(const std::byte* first, std::size_t count, Output& out) noexcept;
};

}  // namespace asap
