#include "asap/algorithms/cluster_view.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace asap {

ClusterOutline outline_of(const Cluster& cluster) noexcept {
  const ClusterView view(cluster);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(view.covariance);  // ascending
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

}  // namespace asap
