// Cluster: what a clusterer says about one object at the moment of the question. Plain data, the
// same for every engine; the Python array of clusters has these fields in this order. In Eigen's
// types: cluster_view.hpp.
#pragma once

#include <cstdint>
#include <limits>

namespace asap {

struct Cluster {
  std::int64_t id;      // never changes while the cluster lives
  double x;             // px, centroid
  double y;             // px
  double vx;            // px/s
  double vy;            // px/s
  double cxx;           // px^2, covariance of the events about the centroid
  double cxy;           // px^2
  double cyy;           // px^2
  std::int64_t size;    // live events
  std::int64_t t_last;  // us, stamp of its newest event
  // px^2, covariance of the error of x and y; infinite: the engine does not know it.
  double pxx = std::numeric_limits<double>::infinity();
  double pxy = 0;
  double pyy = std::numeric_limits<double>::infinity();
};

// The ellipse of two standard deviations of a cluster's events: that of a filled disk is its edge.
struct ClusterOutline {
  double x;      // px, centre
  double y;      // px
  double major;  // px, half-axis
  double minor;  // px, half-axis
  double angle;  // rad, of the major axis: from x (0) towards y, downwards; -pi/2 to pi/2
};

}  // namespace asap
