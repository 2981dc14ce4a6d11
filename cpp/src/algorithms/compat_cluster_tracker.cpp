#include "asap/algorithms/compat_cluster_tracker.hpp"

#include <cstddef>
#include <limits>

#include "algorithms/window_clusterer.hpp"
#include "asap/core/check.hpp"

namespace asap {
namespace {

constexpr std::int64_t kTheLatest = std::numeric_limits<std::int64_t>::min();

}  // namespace

class CompatClusterTracker::Engine {
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

  void read(std::int64_t t_us, std::vector<Cluster>& clusters) const {
    clusterer_.read(clusters, t_us);
  }

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

CompatClusterTracker::CompatClusterTracker(const Config& config)
    : engine_(std::make_unique<Engine>(config)) {}
CompatClusterTracker::~CompatClusterTracker() = default;
CompatClusterTracker::CompatClusterTracker(CompatClusterTracker&&) noexcept = default;
CompatClusterTracker& CompatClusterTracker::operator=(CompatClusterTracker&&) noexcept = default;

void CompatClusterTracker::process(EventSpan events) noexcept {
  Engine& engine = *engine_;
  for (const Event& event : events) engine.process(event);
}

void CompatClusterTracker::process(EventSpan events, std::span<std::int32_t> labels) {
  require(labels.size() == events.size(), "labels.size()", labels.size(),
          "must be the number of events");
  Engine& engine = *engine_;
  for (std::size_t i = 0; i < events.size(); ++i) labels[i] = engine.process(events[i]);
}

std::vector<Cluster> CompatClusterTracker::clusters() const { return clusters_at(kTheLatest); }

void CompatClusterTracker::clusters(std::vector<Cluster>& clusters) const {
  clusters_at(kTheLatest, clusters);
}

std::vector<Cluster> CompatClusterTracker::clusters_at(std::int64_t t_us) const {
  std::vector<Cluster> clusters;
  clusters_at(t_us, clusters);
  return clusters;
}

void CompatClusterTracker::clusters_at(std::int64_t t_us, std::vector<Cluster>& clusters) const {
  engine_->read(t_us, clusters);
}

void CompatClusterTracker::set_keep(double gamma) {
  require(0 <= gamma && gamma <= 1, "gamma", gamma, "must be in [0, 1]");
}

void CompatClusterTracker::reset() noexcept { engine_->reset(); }

std::uint64_t CompatClusterTracker::rejected() const noexcept { return engine_->rejected(); }

const CompatClusterTracker::Config& CompatClusterTracker::config() const noexcept {
  return engine_->config();
}

}  // namespace asap
