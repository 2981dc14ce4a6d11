// TimeSortedBlock and BackgroundNoise: every scene makes, in each time step, a block of events in
// order of time, and adds noise to it. One thread; the constructors fix the memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "asap/core/event.hpp"
#include "core/random.hpp"

namespace asap::inline v0_1 {

// The events of one time step, added in any order, handed out in time order. A counting sort over
// the step's microseconds: O(events + microseconds), stable. The capacity bounds the events between
// open() and close().
class TimeSortedBlock {
 public:
  static constexpr std::int32_t kMaxStep_us = 1000;

  TimeSortedBlock(std::int32_t width, std::int32_t height, std::size_t capacity);

  // Starts the step [start_us, start_us + step_us), 1 <= step_us <= kMaxStep_us.
  void open(std::int64_t start_us, std::int32_t step_us) noexcept;

  std::int32_t step_us() const noexcept { return step_us_; }

  // One event, offset_us after the start of the step. What lies outside the sensor is not seen.
  void add(std::int32_t x, std::int32_t y, bool on, std::int32_t offset_us) noexcept {
    const auto column = static_cast<std::uint32_t>(x);
    const auto row = static_cast<std::uint32_t>(y);
    if (column >= width_ || row >= height_) return;
    added_[size_++] = {static_cast<std::uint16_t>(column), static_cast<std::uint16_t>(row),
                       static_cast<std::uint16_t>(on), static_cast<std::uint16_t>(offset_us)};
  }

  // The events of the step; valid until the next close().
  [[nodiscard]] EventSpan close() noexcept;

 private:
  struct Added {
    std::uint16_t x;
    std::uint16_t y;
    std::uint16_t on;
    std::uint16_t offset_us;
  };

  std::uint32_t width_;
  std::uint32_t height_;
  std::int64_t start_us_ = 0;
  std::int32_t step_us_ = 1;
  std::size_t size_ = 0;
  std::vector<Added> added_;
  std::vector<std::uint32_t> places_;  // per microsecond: where its next event goes
  std::vector<Event> sorted_;
};

// Events without a cause, as every sensor adds them. Each microsecond holds one with the same
// probability (a Bernoulli process), at a uniform pixel, of random polarity; a pure function of
// (seed, microsecond). O(microseconds).
class BackgroundNoise {
 public:
  // noise_hz: events per second and pixel; at most one event per microsecond over the sensor.
  BackgroundNoise(std::int32_t width, std::int32_t height, double noise_hz, std::uint64_t seed);

  // Adds the events of the block's step, which starts elapsed_us after the start of the stream.
  void add_to(TimeSortedBlock& block, std::int64_t elapsed_us) const noexcept;

 private:
  CounterRandom random_;
  std::uint64_t width_;
  std::uint64_t height_;
  double probability_;
};

}  // namespace asap::inline v0_1
