// PoissonArrivals: events of a given rate, an inhomogeneous Poisson process. In each step of 0.1 ms
// the rate is the grid's times exp(noise y - noise^2/2), of mean 1; y is a stationary Gaussian
// AR(1) of unit variance and 1 ms correlation time. Pixels are uniform, polarities random. A step's
// events are a function of (seed, step, rate): how the rates are cut into grids changes nothing.
// Thread and allocation as EventStream, except feed(), which copies its grid; a few ns per event.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "asap/core/event.hpp"
#include "asap/synthetic/event_stream.hpp"

namespace asap {

struct PoissonArrivalsConfig {
  std::int32_t width = 346;
  std::int32_t height = 260;
  std::int64_t duration_us = 5'000'000;
  std::int64_t t0_us = 0;
  double noise = 0.2;  // sigma of the logarithm of the rate
  std::uint64_t seed = 0;
};

class PoissonArrivals final : public EventStream {
 public:
  static constexpr std::int64_t kStep_us = 100;
  static constexpr double kMaxRate_hz = 2e9;

  explicit PoissonArrivals(const PoissonArrivalsConfig& config = {});
  ~PoissonArrivals() override;
  PoissonArrivals(PoissonArrivals&& other) noexcept;
  PoissonArrivals& operator=(PoissonArrivals&& other) noexcept;

  // The rates of the next steps, events per second; what lies beyond the duration is ignored.
  void feed(std::span<const double> rates_hz);

  // Empty when the rates are used up (it goes on after the next feed) or the duration is over.
  [[nodiscard]] EventSpan next() noexcept override;

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace asap
