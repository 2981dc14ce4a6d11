// PoissonArrivals: events of a given rate, an inhomogeneous Poisson process: what
// asap_laboratory.profiles is made of. In each step of 0.1 ms the rate is the grid's times
// exp(noise y - noise^2/2), of mean 1; y is a stationary Gaussian AR(1) of unit variance and 1 ms
// correlation time. Pixels are uniform, polarities random. A step's events are a function of (seed,
// step, rate): how the rates are cut into grids changes nothing. Thread and allocation as
// EventStream, except feed(), which copies its grid.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "asap/synthetic/streams.hpp"
#include "core/random.hpp"
#include "study/portable_math.hpp"

namespace asap {

struct PoissonArrivalsConfig {
  std::int32_t width = 346;
  std::int32_t height = 260;
  std::chrono::microseconds duration{5'000'000};
  std::chrono::microseconds start{};  // timestamp from which times count
  double noise = 0.2;                 // sigma of the logarithm of the rate
  std::uint64_t seed = 0;
};

class PoissonArrivals final : public EventStream {
 public:
  static constexpr std::int64_t kStep_us = 100;
  static constexpr double kMaxRate_hz = 2e9;

  explicit PoissonArrivals(const PoissonArrivalsConfig& config = {});

  // The rates of the next steps, events per second; what lies beyond the duration is ignored.
  void feed(std::span<const double> rates_hz);

  // Empty when the rates are used up (it goes on after the next feed) or the duration is over.
  [[nodiscard]] EventSpan next() noexcept override;

 private:
  bool to_next_event() noexcept;
  void open_step(double rate_hz) noexcept;

  PoissonArrivalsConfig config_;
  CounterRandom steps_;    // one key per step
  CounterRandom flicker_;  // drives y
  std::vector<double> rates_hz_;
  std::size_t next_rate_ = 0;
  double log_factor_ = 0.0;  // y

  CounterRandom step_;  // draws numbers of events and pixels of the open step
  std::uint64_t drawn_ = 0;
  std::uint64_t pieces_ = 0;  // draws that make up a microsecond's number; 0: no events
  synthetic::PoissonTable piece_;

  std::int64_t elapsed_us_ = 0;
  std::uint64_t left_ = 0;  // events of the last microsecond, still to come
  std::vector<Event> block_;
};

}  // namespace asap
