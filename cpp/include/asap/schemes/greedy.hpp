// Greedy: when the algorithm is free it gets all that waits, gamma 1. Optimal for the latency at a
// constant rate as long as the algorithm keeps up; no bound on anything as soon as it does not.
//
// With an efficiency eta a package is capped at n = eta / (1 - eta) alpha / beta, of which eta is
// time for events: oldest first, the rest waits. That shortens the longest latency after abrupt
// changes (notebooks/theory.md, T4), as long as eta stays well above the mean load. alpha and beta
// are learned. On the consumer's thread, O(1) per package, no allocation.
//
//   Greedy scheme;
//   Replay replay{scheme, {.speed = 1.0}, {}};
#pragma once

#include <optional>

#include "asap/schemes/scheme.hpp"

namespace asap::inline v0_1 {

struct GreedyConfig {
  std::optional<double> efficiency{};  // eta, 0 < eta < 1; none: no cap. 0.97 is a good one

  static constexpr std::tuple kParameters{
      NamedField{"efficiency", &GreedyConfig::efficiency},
  };
};

class Greedy final : public LearningScheme {
 public:
  using Config = GreedyConfig;

  explicit Greedy(Config config = {});
};

}  // namespace asap::inline v0_1
