// ShakenPattern: the abrupt-motion experiment of the paper (Tapia et al. 2020): a printed pattern
// shaken harder and harder in front of the sensor. The print is a poster of small disks, squares
// and triangles; it moves on an ellipse whose radius and frequency both grow, so that the event
// rate climbs as first + (last - first) (t/duration)^1.5 with mild pulses at twice the frequency.
// Thread and allocation as EventStream; about 10 ns per event.
#pragma once

#include <cstdint>

#include "asap/synthetic/background_noise.hpp"
#include "asap/synthetic/event_stream.hpp"
#include "asap/synthetic/outline.hpp"
#include "asap/synthetic/time_sorted_block.hpp"
#include "asap/synthetic/unit_vector.hpp"

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

  [[nodiscard]] EventSpan next() noexcept override;

 private:
  double progress() const noexcept;  // 0 at the start, 1 at the end
  double amplitude_px() const noexcept;
  double speed_px_s() const noexcept;  // mean over the ellipse
  Outline::Place place() const noexcept;
  std::int32_t step_us() const noexcept;

  ShakenPatternConfig config_;
  Outline print_;
  BackgroundNoise noise_;
  TimeSortedBlock block_;
  double events_per_px_;
  std::int64_t elapsed_us_ = 0;
  UnitVector phase_;
};

}  // namespace asap
