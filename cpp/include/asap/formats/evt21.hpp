// Evt21Decoder: events of a Prophesee EVT2.1 stream, 64-bit words that hold up to 32 events.
//
// Type in bits 63:60: 0 OFF and 1 ON with t 59:54, x 53:43, y 42:32 and a mask in 31:0, whose bit i
// is an event at x + i; 8 TIME_HIGH with t >> 6 in 59:32, often repeated; 10 external trigger with
// t 59:54, id 44:40, value 32; 14 and 15 others. Little-endian words, or "legacy": their two 32-bit
// halves are swapped. Only the header says which; without the key the practice is legacy.
// Times unwrap every 2^34 us, where TIME_HIGH falls by more than half its range. Events before the
// first TIME_HIGH are dropped: their time is unknown.
//
// One thread. Never throws, never allocates. O(bytes).
#pragma once

#include "asap/core/event.hpp"
#include "asap/formats/evt2.hpp"
#include "asap/formats/progress.hpp"

namespace asap {

struct Evt21Config {
  bool little_endian = false;      // else legacy
  std::uint64_t first_offset = 0;  // offset in the file of the first byte that is fed
};

class Evt21Decoder : public Evt2Words<Evt21Decoder, Evt21Config, 8> {
 public:
  static constexpr std::size_t kMostPerRecord = 32;  // events that one word can give

  explicit Evt21Decoder(Evt21Config config = {}) noexcept
      : Evt2Words(config, config.first_offset) {}

 private:
  friend NativeDecoder;

  std::size_t decode_words(const std::byte* first, std::size_t count, Output& out) noexcept;
  template <bool kLittleEndian>
  std::size_t decode_in_order(const std::byte* first, std::size_t count, Output& out) noexcept;
  bool decode_any(std::uint64_t word, std::uint64_t offset, Output& out) noexcept;
};

}  // namespace asap
