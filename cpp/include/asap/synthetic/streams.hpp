// EventStream: a seeded stream of synthetic events, made block by block as it is read. Times never
// go back, memory is allocated in the constructor alone, and the same configuration gives the same
// events on every compiler: streams decide with integers, + - * / and sqrt only, compiled with
// -ffp-contract=off, hence in .cpp files. Any one thread reads; one virtual call per block.
//
//   FlightOverChairs stream{{.duration = 1s}};
//   for (auto block = stream.next(); !block.empty(); block = stream.next()) tracker.process(block);
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "asap/core/event.hpp"

namespace asap::inline v0_1 {

// ---- a stream ----------------------------------------------------------------------------------

class EventStream : public EventSource {
 public:
  // Never blocks, never throws.
  [[nodiscard]] EventSpan next() noexcept override = 0;
};

// Reads whole blocks until there are `at_least` events or the stream has ended; empty at the end.
inline std::vector<Event> read_events(EventStream& stream, std::size_t at_least) {
  std::vector<Event> events;
  events.reserve(std::min<std::size_t>(at_least, 1 << 20) * 5 / 4);  // the last block may exceed
  while (events.size() < at_least) {
    const EventSpan block = stream.next();
    if (block.empty()) break;
    events.insert(events.end(), block.begin(), block.end());
  }
  return events;
}

// ---- Poisson arrivals --------------------------------------------------------------------------

// PoissonArrivals: events of a given rate, an inhomogeneous Poisson process. In each step of 0.1 ms
// the rate is the grid's times exp(noise y - noise^2/2), of mean 1; y is a stationary Gaussian
// AR(1) of unit variance and 1 ms correlation time. Pixels are uniform, polarities random. A step's
// events are a function of (seed, step, rate): how the rates are cut into grids changes nothing.
// Thread and allocation as EventStream, except feed(), which copies its grid.

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
  ~PoissonArrivals() override;
  PoissonArrivals(PoissonArrivals&& other) noexcept;
  PoissonArrivals& operator=(PoissonArrivals&& other) noexcept;

  // The rates of the next steps, events per second; what lies beyond the duration is ignored.
  void feed(std::span<const double> rates_hz);

  // Empty when the rates are used up (it goes on after the next feed) or the duration is over.
  [[nodiscard]] EventSpan next() noexcept override;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

// ---- a shaken pattern --------------------------------------------------------------------------

// ShakenPattern: the abrupt-motion experiment of the paper (Tapia et al. 2020): a printed pattern
// shaken harder and harder in front of the sensor. The print is a poster of small disks, squares
// and triangles; it moves on an ellipse whose radius and frequency both grow, so that the event
// rate climbs as first + (last - first) (t/duration)^1.5 with mild pulses at twice the frequency.
// Thread and allocation as EventStream.

struct ShakenPatternConfig {
  std::int32_t width = 346;
  std::int32_t height = 260;
  std::chrono::microseconds duration{5'000'000};
  std::chrono::microseconds start{};  // timestamp from which times count
  double first_rate_hz = 0.1e6;       // events per second of the print, at the start ...
  double last_rate_hz = 13e6;         // ... and at the end
  double amplitude_px = 18.0;         // longer half-axis of the shake at the end
  double noise_hz = 0.1;              // background events per second and pixel
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
  class Impl;
  std::unique_ptr<Impl> impl_;
};

// ---- a flight over chairs ----------------------------------------------------------------------

// FlightOverChairs: the on-board experiment of the paper (Tapia et al. 2020): a slightly swaying
// flight over a growing number of chairs, seen obliquely from above. Chairs stand in rows that
// enter at the top and leave at the bottom, few chairs at first, full rows at the end; the speed
// grows too. Thread and allocation as EventStream (a row that left is filled again), whatever the
// duration.

struct FlightOverChairsConfig {
  std::int32_t width = 346;
  std::int32_t height = 260;
  std::chrono::microseconds duration{4'000'000};
  std::chrono::microseconds start{};  // timestamp from which times count
  double last_rate_hz = 1.8e6;        // events per second of the chairs at the end; sets the speed
  double chair_px = 40.0;             // width of a chair
  double noise_hz = 0.1;              // background events per second and pixel
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
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace asap::inline v0_1
