// FlightOverChairs: the on-board experiment of the paper (Tapia et al. 2020): a slightly swaying
// flight over a growing number of chairs, seen obliquely from above. Chairs stand in rows that
// enter at the top and leave at the bottom, few chairs at first, full rows at the end; the speed
// grows too. Thread and allocation as EventStream (a row that left is filled again), whatever the
// duration.
#pragma once

#include <cstdint>
#include <vector>

#include "asap/core/random.hpp"
#include "asap/synthetic/background_noise.hpp"
#include "asap/synthetic/event_stream.hpp"
#include "asap/synthetic/outline.hpp"
#include "asap/synthetic/time_sorted_block.hpp"
#include "asap/synthetic/unit_vector.hpp"

namespace asap {

struct FlightOverChairsConfig {
  std::int32_t width = 346;
  std::int32_t height = 260;
  std::int64_t duration_us = 4'000'000;
  std::int64_t t0_us = 0;
  double last_rate_hz = 1.8e6;  // events per second of the chairs at the end; sets the speed
  double chair_px = 40.0;       // width of a chair
  double noise_hz = 0.1;        // background events per second and pixel
  std::uint64_t seed = 0;
};

class FlightOverChairs final : public EventStream {
 public:
  explicit FlightOverChairs(const FlightOverChairsConfig& config = {});

  [[nodiscard]] EventSpan next() noexcept override;

 private:
  struct View {
    double flown_px;
    double sway_px;
  };

  std::int32_t step_us() const noexcept;
  void sweep(View from, View to) noexcept;
  View view() const noexcept;
  double flown_px(std::int64_t elapsed_us) const noexcept;
  Outline::Place place_of(std::int64_t row, View view) const noexcept;

  void fill(std::int64_t row) noexcept;
  double chairs_before(std::int64_t row) const noexcept;
  Outline& outline_of(std::int64_t row) noexcept;

  FlightOverChairsConfig config_;
  std::int32_t lanes_;
  double row_pitch_px_;
  double last_speed_px_s_;
  double first_full_row_;
  CounterRandom layout_;
  BackgroundNoise noise_;
  std::vector<Outline> rows_;  // row r in slot r modulo size, from nearest_row_ on
  TimeSortedBlock block_;
  std::int64_t nearest_row_ = 0;
  std::int64_t elapsed_us_ = 0;
  UnitVector sway_;
};

}  // namespace asap
