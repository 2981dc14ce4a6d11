// DeadBeat: the simplest scheme that keeps a latency bound L (notebooks/theory.md, section 5). No
// package is longer than L / 2, and every package takes all that waits: then nothing that waits is
// older than L / 2 when a package starts, and L when it ends. What does not fit is thinned evenly.
// It settles in one package: no rate estimate, no gain, no integrator. `Deadline` keeps more at the
// end of a rush; this is the text-book.
//
//   1 hold     while packages would waste the processor and the bound allows it (HoldRule)
//   2 length   T = L / 2; in overload no longer than the knee K alpha, where throughput saturates
//   3 stale    the package ends before the oldest event is L old; what cannot make it is dropped
//   4 count    n = (H - alpha) / beta of the N events that are there
//
// Called on the consumer's thread, once or twice per package. O(1), no allocation.
//
//   DeadBeat scheme;
//   Pipeline pipeline{scheme, {.latency = 10ms}};
#pragma once

#include "asap/schemes/scheme.hpp"

namespace asap::inline v0_1 {

struct DeadBeatConfig {
  std::chrono::nanoseconds latency = kDefaultLatency;  // L
  double knee = 33.0;      // K: keeps 1 - 1 / K of the throughput; 0 = T is always L / 2
  double overhead = 0.25;  // permitted share of fixed costs in the processor, 0 = any
  std::chrono::nanoseconds min_interval{};  // shortest time between package starts

  static constexpr std::tuple kParameters{
      NamedField{"latency_ms", &DeadBeatConfig::latency},
      NamedField{"knee", &DeadBeatConfig::knee},
      NamedField{"overhead", &DeadBeatConfig::overhead},
      NamedField{"min_interval_ms", &DeadBeatConfig::min_interval},
  };
};

class DeadBeat final : public LearningScheme {
 public:
  using Config = DeadBeatConfig;

  explicit DeadBeat(Config config = {});

  // What a package costs, as far as it is known.
  double alpha_ns() const noexcept;
  double beta_ns() const noexcept;
};

}  // namespace asap::inline v0_1
