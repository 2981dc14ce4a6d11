#include "asap/algorithms/cluster_tracker.hpp"

#include <chrono>

#include "algorithms/fast/constants.hpp"
#include "algorithms/fast/engine.hpp"
#include "asap/algorithms/published_cluster_tracker.hpp"
#include "core/check.hpp"
#include "core/made.hpp"

namespace asap::inline v0_1 {

namespace {

using namespace std::chrono_literals;

const ClusterTrackerConfig& checked(const ClusterTrackerConfig& config) {
  constexpr double kFarthest_px = 4'096;  // the engine's floats stay finite
  const auto require_side = [](const char* field, int value) {
    require(1 <= value && value <= 16'384, field, value, "must be 1 to 16384 px");
  };
  const auto require_radius = [](const char* field, double value) {
    require(fast::kMinRadius_px <= value && value <= kFarthest_px, field, value,
            "must be 7 to 4096 px");  // false for NaN
  };
  const auto require_duration = [](const char* field, std::chrono::nanoseconds value) {
    require_time(1us <= value && value <= 60s, field, value, TimeUnit::ms,
                 "must be 0.001 ms to 60 s");
  };
  require_side("width", config.width);
  require_side("height", config.height);
  require(1 <= config.slots && config.slots <= 256, "slots", config.slots, "must be 1 to 256");
  require_known(config.support, ClusterSupport::kReject, "support");
  require_duration("support_window", config.support_window);
  require_radius("birth_radius_px", config.birth_radius_px);
  require_radius("max_radius_px", config.max_radius_px);
  require(fast::kDieEvents <= config.confirm_events && config.confirm_events <= 60'000,
          "confirm_events", config.confirm_events, "must be 2 to 60000");
  require_duration("coast", config.coast);
  return config;
}

// The moments of all events of these clusters, each of which has events of late.
Cluster joined(std::span<const Cluster> parts) noexcept {
  Cluster all{};
  double total = 0;
  for (const Cluster& part : parts) {
    const double weight = 1 + static_cast<double>(part.size);
    total += weight;
    const double share = weight / total;
    const double dx = part.x - all.x;
    const double dy = part.y - all.y;
    const double apart = share * (1 - share);
    all.cxx += share * (part.cxx - all.cxx) + apart * dx * dx;
    all.cxy += share * (part.cxy - all.cxy) + apart * dx * dy;
    all.cyy += share * (part.cyy - all.cyy) + apart * dy * dy;
    all.x += share * dx;
    all.y += share * dy;
  }
  return all;
}

}  // namespace

class ClusterTracker::Impl {
 public:
  explicit Impl(const Config& given) : config(checked(given)), engine(config) {}

  std::vector<Cluster> parts(std::int64_t object) const {
    std::vector<Cluster> clusters;
    engine.read_parts(object, clusters);
    return clusters;
  }

  Config config;
  fast::Engine engine;
};

ClusterTracker::ClusterTracker(const Config& config) : impl_(std::make_unique<Impl>(config)) {}
ClusterTracker::~ClusterTracker() = default;
ClusterTracker::ClusterTracker(ClusterTracker&&) noexcept = default;
ClusterTracker& ClusterTracker::operator=(ClusterTracker&&) noexcept = default;

void ClusterTracker::process(EventSpan events) noexcept { impl_->engine.process(events, nullptr); }

void ClusterTracker::process(EventSpan events, std::span<std::int32_t> labels) {
  require(labels.size() == events.size(), "labels.size()", labels.size(),
          "must be the number of events");
  impl_->engine.process(events, labels.data());
}

std::vector<Cluster> ClusterTracker::clusters() const {
  return clusters_at(impl_->engine.latest_us());
}

void ClusterTracker::clusters(std::vector<Cluster>& clusters) const {
  clusters_at(impl_->engine.latest_us(), clusters);
}

std::vector<Cluster> ClusterTracker::clusters_at(std::int64_t t_us) const {
  std::vector<Cluster> clusters;
  clusters_at(t_us, clusters);
  return clusters;
}

void ClusterTracker::clusters_at(std::int64_t t_us, std::vector<Cluster>& clusters) const {
  impl_->engine.read(t_us, clusters);
}

std::vector<TrackedObject> ClusterTracker::objects() const {
  return objects_at(impl_->engine.latest_us());
}

void ClusterTracker::objects(std::vector<TrackedObject>& objects) const {
  objects_at(impl_->engine.latest_us(), objects);
}

std::vector<TrackedObject> ClusterTracker::objects_at(std::int64_t t_us) const {
  std::vector<TrackedObject> objects;
  objects_at(t_us, objects);
  return objects;
}

void ClusterTracker::objects_at(std::int64_t t_us, std::vector<TrackedObject>& objects) const {
  impl_->engine.read(t_us, objects);
}

void ClusterTracker::to_objects(std::span<std::int32_t> labels) const noexcept {
  for (std::int32_t& label : labels) label = impl_->engine.object_of(label);
}

std::vector<std::int64_t> ClusterTracker::members(std::int64_t id) const {
  std::vector<std::int64_t> ids;
  for (const Cluster& part : impl_->parts(id)) ids.push_back(part.id);
  return ids;
}

std::optional<ClusterOutline> ClusterTracker::outline(std::int64_t id) const {
  const std::vector<Cluster> parts = impl_->parts(id);
  if (parts.empty()) return std::nullopt;
  return outline_of(joined(parts));
}

void ClusterTracker::advance_to(std::int64_t t_us) noexcept { impl_->engine.advance_to(t_us); }

void ClusterTracker::set_gamma(double gamma, bool filter_upstream) {
  require(0 <= gamma && gamma <= 1, "gamma", gamma, "must be in [0, 1]");
  impl_->engine.set_gamma(gamma, filter_upstream);
}

void ClusterTracker::reset() noexcept { impl_->engine.reset(); }

std::uint64_t ClusterTracker::rejected() const noexcept {
  return impl_->engine.counters().rejected;
}

std::uint64_t ClusterTracker::unsupported() const noexcept {
  return impl_->engine.counters().unsupported;
}

std::uint64_t ClusterTracker::refused() const noexcept { return impl_->engine.counters().refused; }

const ClusterTracker::Config& ClusterTracker::config() const noexcept { return impl_->config; }

template <class Made>
Result<Made> make_tracker(const typename Made::Config& config) noexcept {
  return made<Made>([&] { return std::make_unique<Made>(config); });
}

template Result<ClusterTracker> make_tracker<ClusterTracker>(const ClusterTrackerConfig&) noexcept;
template Result<PublishedClusterTracker> make_tracker<PublishedClusterTracker>(
    const PublishedClusterTrackerConfig&) noexcept;

}  // namespace asap::inline v0_1
