// FlightOverChairs: the on-board experiment of the paper (Tapia et al. 2020): a slightly swaying
// flight over a growing number of chairs, seen obliquely from above. Chairs stand in rows that
// enter at the top and leave at the bottom, few chairs at first, full rows at the end; the speed
// grows too. Thread and allocation as EventStream (a row that left is filled again), whatever the
// duration.
#pragma once

#include <cstdint>
#include <memory>

#include "asap/core/event.hpp"
#include "asap/synthetic/event_stream.hpp"

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
  ~FlightOverChairs() override;
  FlightOverChairs(FlightOverChairs&& other) noexcept;
  FlightOverChairs& operator=(FlightOverChairs&& other) noexcept;

  [[nodiscard]] EventSpan next() noexcept override;

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace asap
