// DatDecoder: events of a Prophesee DAT file, 8 bytes each.
//
// t in us, 32 bits; then version 2: x 13:0, y 27:14, p 31:28; version 1: x 8:0, y 16:9, p 17. Types
// 0 and 12 are both change detections. Times unwrap every 2^32 us, where they fall by more than
// half of it.
//
// One thread. Feed it bytes cut anywhere; never throws, never allocates. O(bytes). Order, sensor
// size and polarity are the Validator's.
#pragma once

#include <optional>

#include "asap/core/event.hpp"
#include "asap/formats/progress.hpp"
#include "asap/formats/raw_header.hpp"

namespace asap {

struct Output;

struct DatConfig {
  int version = 2;
  std::uint64_t first_offset = 0;  // offset in the file of the first byte that is fed
};

struct DatHeader {
  std::size_t size = 0;  // bytes, type and size of an event included
  int version = 2;       // where it is not stated, the first events decide
  std::uint8_t type = 0;
  std::uint8_t event_size = 0;  // bytes
  std::uint16_t width = 0;      // px; 0: not stated
  std::uint16_t height = 0;
};

// Nothing if `bytes` do not begin with a header of text lines and two bytes.
std::optional<DatHeader> read_dat_header(std::span<const std::byte> bytes) noexcept;

class DatDecoder {
 public:
  static constexpr std::size_t kMostPerRecord = 1;  // events

  explicit DatDecoder(DatConfig config = {});

  // Decodes from the front of `bytes` until they or `events` end.
  Progress decode(std::span<const std::byte> bytes, std::span<Event> events) noexcept;

  // Bytes of an event that waits for its end; > 0 at the end of the input: the file was cut.
  std::size_t unfinished() const noexcept { return state_.cut.size; }

  std::uint64_t bad_records() const noexcept { return 0; }  // any 8 bytes are an event
  std::span<const std::uint64_t> noted() const noexcept { return {}; }

  void reset() noexcept {
    state_ = {};
    state_.offset = config_.first_offset;
  }

 private:
  struct State {
    std::int64_t t = 0;  // us, of the last event, unwrapped
    std::uint64_t offset = 0;
    CutRecord<8> cut;
  };

  template <int kVersion>
  std::size_t decode_words(const std::byte* first, std::size_t count, Output& out) noexcept;

  DatConfig config_;
  State state_;
};

}  // namespace asap
