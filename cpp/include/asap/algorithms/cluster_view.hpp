// ClusterView: position, velocity and covariance of a cluster in Eigen's types, for a program that
// goes on with them: a filter, a gate, a controller. outline_of() tells the axes of its covariance.
// Any thread; O(1), no allocation.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>

#include "asap/algorithms/cluster_tracker.hpp"

namespace asap {

struct ClusterView {
  explicit ClusterView(const Cluster& cluster) noexcept
      : position(cluster.x, cluster.y), velocity(cluster.vx, cluster.vy) {
    covariance << cluster.cxx, cluster.cxy, cluster.cxy, cluster.cyy;
  }

  Eigen::Vector2d position;    // px
  Eigen::Vector2d velocity;    // px/s
  Eigen::Matrix2d covariance;  // px^2, of the events about the centroid
};

ClusterOutline outline_of(const Cluster& cluster) noexcept;

// That of the cluster with this id. Empty: there is none.
std::optional<ClusterOutline> outline_of(std::int64_t id,
                                         std::span<const Cluster> clusters) noexcept;

}  // namespace asap
