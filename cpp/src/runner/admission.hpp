// Thinning on arrival, in front of the ring. It exists for the rivals of the benchmark that thin
// the stream before they know what waits (study/); the simulator asks them, no product does.
// Virtual time; one thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "asap/core/event.hpp"
#include "asap/core/time.hpp"
#include "asap/filter/gamma_filter.hpp"
#include "asap/runner/simulator.hpp"
#include "telemetry/gap_meter.hpp"

namespace asap::inline v0_1 {

// What has happened since it was last asked.
struct Arrivals {
  std::int64_t now_ns;
  std::size_t arrived;     // raw events, before the filter
  std::size_t waiting;     // in the ring, now
  std::int64_t oldest_ns;  // time of the oldest waiting event; now_ns if there is none
};

class Admission {
 public:
  virtual ~Admission() = default;

  // A simulator that asks `admission`, if there is one. Scheme and admission outlive it. With an
  // admission no mask is kept. `speed`: as in ReplayConfig.
  static std::unique_ptr<Simulator> simulator(Scheme& scheme, SimulatedCost cost, RunConfig config,
                                              Consumer consumer, Admission* admission,
                                              double speed = 1.0);

  // Kept fraction of what arrives until it is asked again.
  virtual double gamma(const Arrivals& arrivals) noexcept = 0;
  // How often it is asked, > 0.
  virtual std::int64_t period_ns() const noexcept = 0;
};

// Thins a stream as an Admission says, period by period. O(1) per event; allocates only to grow its
// block.
class AdmissionGate {
 public:
  // The admission outlives the gate.
  AdmissionGate(Admission& admission, std::uint64_t seed) noexcept
      : admission_(admission), filter_(seed) {}

  // Fills in what waits at arrivals.now_ns.
  using Look = std::function<void(Arrivals&)>;
  // Gets the events of one period that were let in; may be empty.
  using Sink = std::function<void(EventSpan)>;

  void pass(EventSpan events, const TimeAxis& axis, const Look& look, const Sink& sink);

  std::uint64_t seen() const noexcept { return filter_.position(); }
  std::uint64_t discarded() const noexcept { return discarded_; }
  // The gaps that the discarded events leave.
  const GapMeter& gap() const noexcept { return gap_; }

 private:
  void ask(const Look& look);

  Admission& admission_;
  GammaFilter filter_;
  std::vector<Event> admitted_;
  double gamma_ = 1.0;
  std::int64_t next_ask_ns_ = kLongAgo;
  std::size_t arrived_ = 0;
  std::uint64_t discarded_ = 0;
  GapMeter gap_;
};

}  // namespace asap::inline v0_1
