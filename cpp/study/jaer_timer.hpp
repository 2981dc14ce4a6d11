// JaerTimer: a rival of the benchmark, after jAER's processing timer. Greedy, but the package stops
// when its timer of L/2 has run: n = max(1, (L/2/X - alpha)/beta) of the oldest events, where X and
// beta are the simulated package's own; the rest of what waited when it started is discarded.
// A baseline of an experiment, not a product: it knows the simulated cost.
//
// A decision throws away the oldest only, so the rest goes first thing after the package; until
// then it keeps its place in the ring. O(1) per package.
#pragma once

#include "asap/runner/linear_cost.hpp"
#include "study/rival.hpp"

namespace asap {

class JaerTimer final : public Rival {
 public:
  // The cost of the simulator that it will run in, from that simulator's first package on.
  JaerTimer(double latency_ms, LinearCost cost);

  Decision decide(const Backlog& backlog) noexcept override;
  void observe(const Outcome& outcome) noexcept override;
  void reset(Execution execution) noexcept override;
  std::string_view name() const noexcept override { return "jaer_timer"; }

 private:
  const LinearCost cost_;

  std::uint64_t packages_ = 0;
  std::size_t waited_ = 0;  // when last asked
  std::size_t rest_ = 0;    // of the last package's backlog, to be discarded
};

}  // namespace asap
