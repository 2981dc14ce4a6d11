#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "asap/algorithms/cluster_tracker.hpp"

namespace asap::inline v0_1 {

ClusterOutline outline_of(const Cluster& cluster) noexcept {
  Eigen::Matrix2d covariance;
  covariance << cluster.cxx, cluster.cxy, cluster.cxy, cluster.cyy;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(covariance);  // ascending
  const Eigen::Vector2d half = 2 * solver.eigenvalues().cwiseMax(0).cwiseSqrt();
  const Eigen::Vector2d major = solver.eigenvectors().col(1);
  const double to_the_right = std::copysign(1.0, major.x());
  return {.x = cluster.x,
          .y = cluster.y,
          .major = half.y(),
          .minor = half.x(),
          .angle = std::atan2(to_the_right * major.y(), to_the_right * major.x())};
}

std::optional<ClusterOutline> outline_of(std::int64_t id,
                                         std::span<const Cluster> clusters) noexcept {
  const auto found = std::ranges::find(clusters, id, &Cluster::id);
  return found == clusters.end() ? std::nullopt : std::optional(outline_of(*found));
}

}  // namespace asap::inline v0_1
