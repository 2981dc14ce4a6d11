// Evt3Decoder: events of a Prophesee EVT3 stream, 16-bit little-endian words that change a state.
//
// Type in bits 15:12: 0 ADDR_Y with y 10:0; 2 ADDR_X with p 11, x 10:0: an event; 3 VECT_BASE_X
// with p 11, x 10:0; 4 VECT_12 and 5 VECT_8: a mask from bit 0, whose bit i is an event at base +
// i, then the base moves by 12 or 8; 6 TIME_LOW and 8 TIME_HIGH, 12 bits each; 10 external trigger
// with id 11:8, value 0; 7, 14 and 15 others. Time is (TIME_HIGH << 12) + TIME_LOW: TIME_LOW may
// step back; a repeated TIME_HIGH changes nothing, another one sets TIME_LOW to 0. Unwraps every
// 2^24 us, where TIME_HIGH falls by more than half its range. Camera drivers cut the stream
// anywhere: keep one decoder over all packets.
//
// One thread. Feed it bytes cut anywhere; never throws, never allocates. O(bytes). Order and sensor
// size are the Validator's.
#pragma once

#include "asap/core/event.hpp"
#include "asap/formats/progress.hpp"

namespace asap {

struct Output;

struct Evt3Config {
  std::uint64_t first_offset = 0;  // offset in the file of the first byte that is fed
};

class Evt3Decoder {
 public:
  static constexpr std::size_t kMostPerRecord = 12;  // events that one word can give

  explicit Evt3Decoder(Evt3Config config = {}) noexcept : config_(config) { reset(); }

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

  // Events before the first TIME_HIGH, ADDR_Y or base: what they are is not known, so they are
  // dropped.
  std::uint64_t before_start() const noexcept { return state_.before_start; }

  void reset() noexcept {
    state_ = {};
    state_.offset = config_.first_offset;
  }

 private:
  struct State {
    std::int64_t t = 0;           // us, unwrapped
    std::int64_t high = 0;        // us, of the last TIME_HIGH, unwrapped
    std::uint32_t high_word = 0;  // the last TIME_HIGH; 0: none came yet
    std::uint32_t y = 0;          // px
    std::uint32_t base = 0;       // the last VECT_BASE_X, moved by vectors
    bool has_y = false;
    bool has_base = false;
    std::uint64_t offset = 0;  // of the next word
    std::uint64_t triggers = 0;
    std::uint64_t before_start = 0;
    BadRecords bad;
    CutRecord<2> cut;
  };

  Progress decode(std::span<const std::byte> bytes, const Output& out) noexcept;
  std::size_t decode_words(const std::byte* first, std::size_t count, Output& out) noexcept;
  std::size_t decode_plain(const std::byte* first, std::size_t i, std::size_t end,
                           Output& out) noexcept;
  bool decode_any(std::uint32_t word, std::uint64_t offset, Output& out) noexcept;
  void take_time_high(std::uint32_t word) noexcept;

  Evt3Config config_;
  State state_;
};

}  // namespace asap
