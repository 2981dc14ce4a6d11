// CompatClusterConfig: the parameters of event-by-event clustering and their check. The defaults
// are the launch values of the authors' release. Source: Rodriguez-Gomez et al., "Asynchronous
// Event-Based Clustering and Tracking for Intrusion Monitoring in UAS", ICRA 2020; the symbols in
// brackets are the paper's.
#pragma once

#include <cstdint>

namespace asap {

// What position and velocity of a cluster are. Which event joins what does not depend on it.
enum class CompatMotion {
  kWindow,  // as published: mean of the live events; their regression on time, rough within ms
  kKalman,  // of a filter over the events' means, at the latest time (ClusterMotion)
};

struct CompatClusterConfig {
  int width;               // px
  int height;              // px
  int window = 800;        // [S] events that are remembered, over all clusters
  double radius = 20;      // [R] px, L1 distance within which an event joins a cluster
  int probes = 1;          // [kappa] random live events of each cluster that are tried as well
  double weight = 0.9;     // [alpha] weight of the newest event in the centre
  int min_size = 15;       // [minN] events from which a cluster is reported, and probed beyond
  std::uint64_t seed = 0;  // of the probes
  CompatMotion motion = CompatMotion::kWindow;
};

// Returns its argument; throws std::invalid_argument that names the first bad field.
const CompatClusterConfig& checked(const CompatClusterConfig& config);

}  // namespace asap
