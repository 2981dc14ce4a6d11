// Evt21Decoder: events of a Prophesee EVT2.1 stream, 64-bit words that hold up to 32 events.
//
// Type in bits 63:60: 0 OFF and 1 ON with t 59:54, x 53:43, y 42:32 and a mask in 31:0, whose bit i
// is an event at x + i; 8 TIME_HIGH with t >> 6 in 59:32, often repeated; 10 external trigger with
// t 59:54, id 44:40, value 32; 14 and 15 others. Little-endian words, or "legacy": their two 32-bit
// halves are swapped. Only the header says which; without the key the practice is legacy.
// Times unwrap every 2^34 us, where TIME_HIGH falls by more than half its range.
//
// One thread. Feed it bytes cut anywhere; never throws, never allocates. O(bytes). Order and sensor
// size are the Validator's.
#pragma once

#include "asap/core/event.hpp"
#include "asap/formats/progress.hpp"

namespace asap {

struct Output;

struct Evt21Config {
  bool little_endian = false;      // else legacy
  std::uint64_t first_offset = 0;  // offset in the file of the first byte that is fed
};

class Evt21Decoder {
 public:
  static constexpr std::size_t kMostPerRecord = 32;  // events that one word can give

  explicit Evt21Decoder(Evt21Config config = {}) noexcept : config_(config) { reset(); }

  // Decodes from the front of `bytes` until they end or the next word has no room. Events beyond
  // those reported are overwritten.
  Progress decode(std::span<const std::byte> bytes, std::span<Event> events) noexcept;

  // The same; stops before a trigger that has no room as well.
  Progress decode(std::span<const std::byte> bytes, std::span<Event> events,
                  std::span<Trigger> triggers) noexcept;

  // Bytes of a word that waits for its end; > 0 at the end of the input: the file was cut.
  std::size_t unfinished() const noexcept { return state_.cut.size; }

  std::uint64_t bad_records() const noexcept { return state_.bad.count(); }
  std::span<const std::uint64_t> noted() const noexcept { return state_.bad.noted(); }
  std::uint64_t triggers() const noexcept { return state_.triggers; }

  // Events before the first TIME_HIGH: their time is unknown, so they are dropped.
  std::uint64_t before_start() const noexcept { return state_.before_start; }

  void reset() noexcept {
    state_ = {};
    state_.offset = config_.first_offset;
  }

 private:
  struct State {
    std::int64_t high = 0;     // us, of the last TIME_HIGH, unwrapped
    bool started = false;      // a TIME_HIGH came
    std::uint64_t offset = 0;  // of the next word
    std::uint64_t triggers = 0;
    std::uint64_t before_start = 0;
    BadRecords bad;
    CutRecord<8> cut;
  };

  Progress decode(std::span<const std::byte> bytes, const Output& out) noexcept;
  template <bool kLittleEndian>
  std::size_t decode_words(const std::byte* first, std::size_t count, Output& out) noexcept;
  bool decode_any(std::uint64_t word, std::uint64_t offset, Output& out) noexcept;

  Evt21Config config_;
  State state_;
};

}  // namespace asap
