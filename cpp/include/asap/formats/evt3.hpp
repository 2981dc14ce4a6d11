// Evt3Decoder: events of a Prophesee EVT3 stream, 16-bit little-endian words that change a state.
//
// Type in bits 15:12: 0 ADDR_Y with y 10:0; 2 ADDR_X with p 11, x 10:0: an event; 3 VECT_BASE_X
// with p 11, x 10:0; 4 VECT_12 and 5 VECT_8: a mask from bit 0, whose bit i is an event at base +
// i, then the base moves by 12 or 8; 6 TIME_LOW and 8 TIME_HIGH, 12 bits each; 10 external trigger
// with id 11:8, value 0; 7, 14 and 15 others. Time is (TIME_HIGH << 12) + TIME_LOW: TIME_LOW may
// step back; a repeated TIME_HIGH changes nothing, another one sets TIME_LOW to 0. Unwraps every
// 2^24 us, where TIME_HIGH falls by more than half its range. Camera drivers cut the stream
// anywhere: keep one decoder over all packets. Events before the first TIME_HIGH, ADDR_Y or base
// are dropped: what they are is not known.
//
// One thread. Never throws, never allocates. O(bytes).
#pragma once

#include "asap/core/event.hpp"
#include "asap/formats/progress.hpp"

namespace asap {

struct Evt3Config {
  std::uint64_t first_offset = 0;  // offset in the file of the first byte that is fed
};

class Evt3Decoder : public NativeDecoder<Evt3Decoder, Evt3Config, 2> {
 public:
  static constexpr std::size_t kMostPerRecord = 12;  // events that one word can give

  explicit Evt3Decoder(Evt3Config config = {}) noexcept
      : NativeDecoder(config, config.first_offset) {}

  // Bytes are missing here: events up to the next TIME_HIGH, ADDR_Y or base are dropped. The time
  // goes on.
  void resume() noexcept {
    high_word_ = 0;
    has_y_ = false;
    has_base_ = false;
  }

 private:
  friend NativeDecoder;

  std::size_t decode_words(const std::byte* first, std::size_t count, Output& out) noexcept;
  bool decode_plain(std::uint32_t word, std::uint64_t offset, Output& out) noexcept;
  std::size_t decode_fast(const std::byte* first, std::size_t i, std::size_t end,
                          Output& out) noexcept;
  void take_time_high(std::uint32_t word) noexcept;

  std::int64_t t_ = 0;           // us, unwrapped
  std::int64_t high_ = 0;        // us, of the last TIME_HIGH, unwrapped
  std::uint32_t high_word_ = 0;  // the last TIME_HIGH; 0: none came yet
  std::uint32_t y_ = 0;          // px
  std::uint32_t base_ = 0;       // the last VECT_BASE_X, moved by vectors
  bool has_y_ = false;
  bool has_base_ = false;
};

}  // namespace asap
