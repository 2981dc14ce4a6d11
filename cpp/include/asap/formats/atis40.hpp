// Atis40Decoder: events of 40 bits, as N-MNIST and N-Caltech101 (.bin) and DvsGesture cuts (.bs2)
// hold them.
//
// Layout: no header. A record has 5 bytes, big-endian: x 8 bits, y 8, polarity 1, time in us 23. A
// record with y = 240, one row below the sensor, is no event: it adds 2^13 us to all times that
// follow. Source: the readers of the N-MNIST data set (Orchard et al. 2015). Nothing in these bytes
// tells the format: only the name of the file or the user does.
// One thread. Feed it bytes cut anywhere. O(bytes), no allocation, never throws.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "asap/core/event.hpp"
#include "asap/formats/progress.hpp"

namespace asap {

struct Atis40Config {
  bool marks = true;  // whether y = 240 marks 2^13 us; false: it is a row like any other
};

class Atis40Decoder {
 public:
  static constexpr std::size_t kMostPerRecord = 1;

  explicit Atis40Decoder(const Atis40Config& config = {}) noexcept : marks_(config.marks) {}

  // Decodes from the front of `bytes` until one of them ends.
  Progress decode(std::span<const std::byte> bytes, std::span<Event> events) noexcept;

  // Bytes of a record that waits for its end. At the end of the input: the file was cut.
  std::size_t unfinished() const noexcept { return cut_.size; }
  // Every record has a meaning: there are no bad records and no triggers.
  std::uint64_t bad_records() const noexcept { return 0; }
  std::span<const std::uint64_t> noted() const noexcept { return {}; }
  std::uint64_t triggers() const noexcept { return 0; }

  void reset() noexcept;

 private:
  bool marks_;
  std::int64_t marked_us_ = 0;
  CutRecord<5> cut_;
};

}  // namespace asap
