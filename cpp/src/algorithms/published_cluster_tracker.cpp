#include "asap/algorithms/published_cluster_tracker.hpp"

#include <cmath>
#include <cstddef>

#include "algorithms/window_clusterer.hpp"
#include "asap/algorithms/cluster_tracker.hpp"
#include "core/check.hpp"

namespace asap::inline v0_1 {
namespace {

const PublishedClusterTrackerConfig& checked(const PublishedClusterTrackerConfig& config) {
  constexpr int kMaxSide = 65536;    // pixel coordinates are 16 bits
  constexpr int kMaxWindow = 65535;  // window positions are 16 bits

  const auto is_side = [](int value) { return 1 <= value && value <= kMaxSide; };
  require(is_side(config.width), "width", config.width, "must be 1 to 65536 px");
  require(is_side(config.height), "height", config.height, "must be 1 to 65536 px");
  require(1 <= config.window && config.window <= kMaxWindow, "window", config.window,
          "must be 1 to 65535 events");
  require(std::isfinite(config.radius) && config.radius >= 0, "radius", config.radius,
          "must be finite and at least 0 px");
  require(config.probes >= 0, "probes", config.probes, "must be at least 0");
  require(0 <= config.weight && config.weight <= 1, "weight", config.weight, "must be in [0, 1]");
  require(config.min_size >= 0, "min_size", config.min_size, "must be at least 0 events");
  return config;
}

}  // namespace

class PublishedClusterTracker::Impl {
 public:
  explicit Impl(const Config& config)
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

PublishedClusterTracker::PublishedClusterTracker(const Config& config)
    : impl_(std::make_unique<Impl>(config)) {}
PublishedClusterTracker::~PublishedClusterTracker() = default;
PublishedClusterTracker::PublishedClusterTracker(PublishedClusterTracker&&) noexcept = default;
PublishedClusterTracker& PublishedClusterTracker::operator=(PublishedClusterTracker&&) noexcept =
    default;

void PublishedClusterTracker::process(EventSpan events) noexcept {
  Impl& impl = *impl_;
  for (const Event& event : events) impl.process(event);
}

void PublishedClusterTracker::process(EventSpan events, std::span<std::int32_t> labels) {
  require(labels.size() == events.size(), "labels.size()", labels.size(),
          "must be the number of events");
  Impl& impl = *impl_;
  for (std::size_t i = 0; i < events.size(); ++i) labels[i] = impl.process(events[i]);
}

std::vector<Cluster> PublishedClusterTracker::clusters() const {
  std::vector<Cluster> found;
  clusters(found);
  return found;
}

void PublishedClusterTracker::clusters(std::vector<Cluster>& clusters) const {
  impl_->read(clusters);
}

std::vector<Cluster> PublishedClusterTracker::clusters_at(std::int64_t) const { return clusters(); }

std::optional<ClusterOutline> PublishedClusterTracker::outline(std::int64_t id) const {
  return outline_of(id, clusters());
}

void PublishedClusterTracker::set_gamma(double gamma) {
  require(0 <= gamma && gamma <= 1, "gamma", gamma, "must be in [0, 1]");
}

void PublishedClusterTracker::reset() noexcept { impl_->reset(); }

std::uint64_t PublishedClusterTracker::rejected() const noexcept { return impl_->rejected(); }

const PublishedClusterTracker::Config& PublishedClusterTracker::config() const noexcept {
  return impl_->config();
}

}  // namespace asap::inline v0_1
