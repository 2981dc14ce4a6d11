#include "asap/algorithms/cluster_tracker.hpp"

#include <cstddef>

#include "asap/algorithms/window_clusterer.hpp"
#include "asap/core/check.hpp"

namespace asap {

class ClusterTracker::Engine {
 public:
  explicit Engine(const Config& config)
      : config_(checked(config)), clusterer_(config_, UniformProbe(config_.seed)) {}

  // The id of the cluster that took the event, or kNoId.
  std::int32_t process(const Event& event) noexcept {
    if (event.x >= config_.width || event.y >= config_.height) {
      ++rejected_;
      return WindowClusterer<>::kNoId;
    }
    return clusterer_[clusterer_.update(event)].id;
  }

  void read(std::vector<Cluster>& clusters) const { clusterer_.read(clusters); }

  void reset() noexcept {
    clusterer_.clear();
    rejected_ = 0;
  }

  std::uint64_t rejected() const noexcept { return rejected_; }
  const Config& config() const noexcept { return config_; }

 private:
  Config config_;
  WindowClusterer<> clusterer_;
  std::uint64_t rejected_ = 0;
};

ClusterTracker::ClusterTracker(const Config& config) : engine_(std::make_unique<Engine>(config)) {}
ClusterTracker::~ClusterTracker() = default;
ClusterTracker::ClusterTracker(ClusterTracker&&) noexcept = default;
ClusterTracker& ClusterTracker::operator=(ClusterTracker&&) noexcept = default;

void ClusterTracker::process(EventSpan events) noexcept {
  Engine& engine = *engine_;
  for (const Event& event : events) engine.process(event);
}

void ClusterTracker::process(EventSpan events, std::span<std::int32_t> labels) {
  require(labels.size() == events.size(), "labels.size()", labels.size(),
          "must be the number of events");
  Engine& engine = *engine_;
  for (std::size_t i = 0; i < events.size(); ++i) labels[i] = engine.process(events[i]);
}

std::vector<Cluster> ClusterTracker::clusters() const {
  std::vector<Cluster> clusters;
  engine_->read(clusters);
  return clusters;
}

void ClusterTracker::clusters(std::vector<Cluster>& clusters) const { engine_->read(clusters); }

void ClusterTracker::set_keep(double gamma) {
  require(0 <= gamma && gamma <= 1, "gamma", gamma, "must be in [0, 1]");
}

void ClusterTracker::reset() noexcept { engine_->reset(); }

std::uint64_t ClusterTracker::rejected() const noexcept { return engine_->rejected(); }

const ClusterTracker::Config& ClusterTracker::config() const noexcept { return engine_->config(); }

}  // namespace asap
