// GreedyClear: a rival of the benchmark. Greedy, but when the oldest event is older than L/2 at the
// moment the algorithm is free, everything older than 4 us is discarded first. What "drop the
// queue when late" comes to. A baseline of an experiment, not a product. O(log n) per package.
#pragma once

#include "study/rival.hpp"

namespace asap {

class GreedyClear final : public Rival {
 public:
  using Rival::Rival;

  Decision decide(const Backlog& backlog) noexcept override;
  std::string_view name() const noexcept override { return "greedy_clear"; }
};

}  // namespace asap
