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
