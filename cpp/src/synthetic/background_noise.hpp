// BackgroundNoise: events without a cause, as every sensor adds them. Each microsecond holds one
// with the same probability (a Bernoulli process), at a uniform pixel, of random polarity; a pure
// function of (seed, microsecond). O(microseconds), no allocation.
#pragma once

#include <cstdint>

#include "asap/core/random.hpp"
#include "synthetic/time_sorted_block.hpp"

namespace asap {

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

}  // namespace asap
