// What asap.ClusterTracker is behind its one face: either engine.
#pragma once

#include <cstddef>
#include <span>
#include <variant>
#include <vector>

#include "asap/algorithms/cluster_tracker.hpp"
#include "asap/algorithms/published_cluster_tracker.hpp"

namespace asap::python {

struct EitherClusterTracker {
  std::variant<ClusterTracker, PublishedClusterTracker> engine;

  // Per package: what a runner calls.
  void process(EventSpan events) noexcept {
    std::visit([&](auto& tracker) { tracker.process(events); }, engine);
  }
  void set_keep(double gamma) {
    std::visit([&](auto& tracker) { tracker.set_keep(gamma); }, engine);
  }

  std::vector<std::byte> state() const {
    return std::visit([](const auto& tracker) { return tracker.state(); }, engine);
  }
  void restore(std::span<const std::byte> bytes) {
    std::visit([&](auto& tracker) { tracker.restore(bytes); }, engine);
  }
};

}  // namespace asap::python
