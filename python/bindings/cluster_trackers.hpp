// What asap.ClusterTracker is behind its one face: either engine.
#pragma once

#include <variant>

#include "asap/algorithms/cluster_tracker.hpp"
#include "asap/algorithms/published_cluster_tracker.hpp"

namespace asap::python {

struct EitherClusterTracker {
  std::variant<ClusterTracker, PublishedClusterTracker> engine;

  // Per package: what a runner calls.
  void process(EventSpan events) noexcept {
    std::visit([&](auto& tracker) { tracker.process(events); }, engine);
  }
  void set_gamma(double gamma) {
    std::visit([&](auto& tracker) { tracker.set_gamma(gamma); }, engine);
  }
  void reset() noexcept {
    std::visit([](auto& tracker) { tracker.reset(); }, engine);
  }
};

}  // namespace asap::python
