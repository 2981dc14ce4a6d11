// ShakenPattern: the abrupt-motion experiment of the paper (Tapia et al. 2020): a printed pattern
// shaken harder and harder in front of the sensor. The print is a poster of small disks, squares
// and triangles; it moves on an ellipse whose radius and frequency both grow, so that the event
// rate climbs as first + (last - first) (t/duration)^1.5 with mild pulses at twice the frequency.
// Thread and allocation as EventStream; about 10 ns per event.
#pragma once

#include <cstdint>
#include <memory>

#include "asap/core/event.hpp"
#include "asap/synthetic/event_stream.hpp"

namespace asap {

struct ShakenPatternConfig {
  std::int32_t width = 346;
  std::int32_t height = 260;
  std::int64_t duration_us = 5'000'000;
  std::int64_t t0_us = 0;
  double first_rate_hz = 0.1e6;  // events per second of the print, at the start ...
  double last_rate_hz = 13e6;    // ... and at the end
  double amplitude_px = 18.0;    // longer half-axis of the shake at the end
  double noise_hz = 0.1;         // background events per second and pixel
  std::uint64_t seed = 0;
};

class ShakenPattern final : public EventStream {
 public:
  explicit ShakenPattern(const ShakenPatternConfig& config = {});
  ~ShakenPattern() override;
  ShakenPattern(ShakenPattern&& other) noexcept;
  ShakenPattern& operator=(ShakenPattern&& other) noexcept;

  [[nodiscard]] EventSpan next() noexcept override;

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace asap
