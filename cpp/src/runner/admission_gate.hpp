// AdmissionGate: thins a stream on arrival as an Admission says, period by period. The simulator's,
// for the rivals of the benchmark. One thread; O(1) per event; allocates only to grow its block.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "asap/core/event.hpp"
#include "asap/core/time.hpp"
#include "asap/filter/gamma_filter.hpp"
#include "runner/admission.hpp"

namespace asap {

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

 private:
  void ask(const Look& look);

  Admission& admission_;
  GammaFilter filter_;
  std::vector<Event> admitted_;
  double gamma_ = 1.0;
  std::int64_t next_ask_ns_ = kLongAgo;
  std::size_t arrived_ = 0;
  std::uint64_t discarded_ = 0;
};

}  // namespace asap
