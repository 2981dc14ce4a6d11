#include "algorithms/feature_tracks.hpp"

#include <algorithm>
#include <limits>

#include "core/check.hpp"

namespace asap::inline v0_1 {
namespace {

constexpr std::int64_t kNever_us = std::numeric_limits<std::int64_t>::min();

// Ids are 31 bits, as labels are; after 2^31 of them they begin again.
std::int32_t id_of(std::uint64_t created) noexcept {
  return static_cast<std::int32_t>(created & 0x7fffffffU);
}

const FeatureConfig& checked(const FeatureConfig& config) {
  constexpr int kMaxSide = 16384;
  constexpr int kMaxWindow = 65535;  // tracks have numbers of 16 bits
  constexpr int kNeighbours = 8;
  constexpr std::int64_t kMaxTime_us = 1'000'000'000;

  const auto is_side = [](int value) { return 1 <= value && value <= kMaxSide; };
  require(is_side(config.width), "width", config.width, "must be 1 to 16384 px");
  require(is_side(config.height), "height", config.height, "must be 1 to 16384 px");
  require(1 <= config.window && config.window <= kMaxWindow, "window", config.window,
          "must be 1 to 65535 corner events");
  require(0 <= config.radius && config.radius <= kMaxSide, "radius", config.radius,
          "must be 0 to 16384 px");
  require(0 <= config.min_neighbours && config.min_neighbours < kNeighbours, "min_neighbours",
          config.min_neighbours, "must be 0 to 7");
  require(0 <= config.window_time.count() && config.window_time.count() <= kMaxTime_us, "window_us",
          config.window_time.count(), "must be 0 to 1000000000 us");
  require(1 <= config.velocity_window.count() && config.velocity_window.count() <= kMaxTime_us,
          "velocity_us", config.velocity_window.count(), "must be 1 to 1000000000 us");
  return config;
}

// Corner events that can be remembered: 40 ms of 400 000 per second.
std::size_t capacity(const FeatureConfig& config) {
  constexpr int kMost = 16'384;
  const bool grows = config.window_time.count() > 0;
  return static_cast<std::size_t>(grows ? std::max(config.window, kMost) : config.window);
}

}  // namespace

FeatureTracks::FeatureTracks(const FeatureConfig& config)
    : frame_(checked(config).width, config.height),
      reach_(config.radius * config.radius),
      min_neighbours_(config.min_neighbours),
      velocity_us_(static_cast<double>(config.velocity_window.count())),
      latest_us_(std::size_t{frame_.width()} * frame_.height()),
      window_(static_cast<std::size_t>(config.window)),
      window_time_us_(config.window_time.count()),
      stamps_us_(capacity(config)),
      grid_(config.width, config.height, config.radius),
      places_(grid_.size(), stamps_us_.size()),
      tracks_(stamps_us_.size()) {
  free_.reserve(tracks_.size());
  clear();
}

std::int32_t FeatureTracks::update(const Event& corner) noexcept {
  const std::int64_t oldest_us = remember(corner);
  if (!frame_.contains(corner, 1) || !is_supported(corner, oldest_us)) return kNoId;

  Slot slot = assign(corner);
  if (slot != kNone) {
    move(slot, corner);
  } else {
    slot = free_.back();
    free_.pop_back();
    begin(slot, corner);
  }
  const std::int32_t id = id_of(tracks_[slot].created);
  while (oldest_ != kNone && tracks_[oldest_].last_us <= oldest_us) end(oldest_);
  return id;
}

// Returns the timestamp of the oldest corner event that is remembered.
std::int64_t FeatureTracks::remember(const Event& corner) noexcept {
  clock_.advance(corner.t);
  now_us_ = static_cast<std::int64_t>(clock_.now_us());
  latest_us_[std::size_t{corner.y} * frame_.width() + corner.x] = now_us_;
  const auto forget_oldest = [&] {
    oldest_stamp_ = oldest_stamp_ + 1 < stamps_us_.size() ? oldest_stamp_ + 1 : 0;
    --stamps_;
  };
  if (stamps_ == stamps_us_.size()) forget_oldest();
  stamps_us_[(oldest_stamp_ + stamps_++) % stamps_us_.size()] = now_us_;
  while (stamps_ > window_ && distance_us(stamps_us_[oldest_stamp_], now_us_) >= remembered_us_) {
    forget_oldest();
  }
  return stamps_us_[oldest_stamp_];
}

// The release lets the event count itself too and takes one off, also where all timestamps that are
// remembered are equal and it did not count.
bool FeatureTracks::is_supported(const Event& corner, std::int64_t oldest_us) const noexcept {
  const std::size_t stride = frame_.width();
  const std::int64_t* row = &latest_us_[(corner.y - std::size_t{1}) * stride + corner.x - 1];
  int support = -1;
  for (int y = 0; y < 3; ++y, row += stride) {
    support += (row[0] > oldest_us) + (row[1] > oldest_us) + (row[2] > oldest_us);
  }
  return support > min_neighbours_;
}

// The first-created track within the radius, or none. Ends all others there.
FeatureTracks::Slot FeatureTracks::assign(const Event& corner) noexcept {
  Slot first = kNone;
  grid_.for_each_around(grid_.cell(corner.x, corner.y), [&](std::size_t cell) {
    for (Slot slot = places_.first(cell), next; slot != kNone; slot = next) {
      next = places_.next(slot);
      const std::int32_t dx = tracks_[slot].x - corner.x;
      const std::int32_t dy = tracks_[slot].y - corner.y;
      if (dx * dx + dy * dy > reach_) continue;
      if (first == kNone) {
        first = slot;
        continue;
      }
      const bool is_older = tracks_[slot].created < tracks_[first].created;
      end(is_older ? first : slot);
      first = is_older ? slot : first;
    }
  });
  return first;
}

void FeatureTracks::begin(Slot slot, const Event& corner) noexcept {
  Track& track = tracks_[slot];
  track = {.x = corner.x,
           .y = corner.y,
           .older = kNone,
           .newer = kNone,
           .t_first = clock_.latest_us(),
           .t_last = clock_.latest_us(),
           .last_us = now_us_,
           .created = created_++,
           .size = 1,
           .motion = {}};
  track.motion.add(corner.x, corner.y, 0, velocity_us_);
  places_.enter(slot, grid_.cell(corner.x, corner.y));
  append(slot);
}

void FeatureTracks::move(Slot slot, const Event& corner) noexcept {
  Track& track = tracks_[slot];
  track.motion.add(corner.x, corner.y, static_cast<double>(distance_us(track.last_us, now_us_)),
                   velocity_us_);
  track.x = corner.x;
  track.y = corner.y;
  track.t_last = clock_.latest_us();
  track.last_us = now_us_;
  ++track.size;
  places_.move(slot, grid_.cell(corner.x, corner.y));
  unlink(slot);
  append(slot);
}

void FeatureTracks::end(Slot slot) noexcept {
  places_.leave(slot);
  unlink(slot);
  free_.push_back(slot);
}

void FeatureTracks::append(Slot slot) noexcept {
  tracks_[slot].older = newest_;
  tracks_[slot].newer = kNone;
  (newest_ == kNone ? oldest_ : tracks_[newest_].newer) = slot;
  newest_ = slot;
}

void FeatureTracks::unlink(Slot slot) noexcept {
  const Slot older = tracks_[slot].older;
  const Slot newer = tracks_[slot].newer;
  (older == kNone ? oldest_ : tracks_[older].newer) = newer;
  (newer == kNone ? newest_ : tracks_[newer].older) = older;
}

void FeatureTracks::read(std::vector<FeatureTrack>& tracks) const {
  tracks.clear();
  for (Slot slot = oldest_; slot != kNone; slot = tracks_[slot].newer) {
    const Track& track = tracks_[slot];
    const DiscountedMotion::Velocity velocity = track.motion.velocity();  // px/us
    tracks.push_back({.id = static_cast<std::int64_t>(track.created),
                      .x = static_cast<double>(track.x),
                      .y = static_cast<double>(track.y),
                      .vx = velocity.x * 1e6,
                      .vy = velocity.y * 1e6,
                      .size = static_cast<std::int64_t>(track.size),
                      .t_first = track.t_first,
                      .t_last = track.t_last});
  }
  std::sort(tracks.begin(), tracks.end(),
            [](const FeatureTrack& a, const FeatureTrack& b) { return a.id < b.id; });
  for (FeatureTrack& track : tracks) track.id = id_of(static_cast<std::uint64_t>(track.id));
}

void FeatureTracks::set_gamma(double gamma) noexcept {
  constexpr double kMinGamma = 0.01;
  remembered_us_ =
      static_cast<std::uint64_t>(static_cast<double>(window_time_us_) / std::max(kMinGamma, gamma));
}

void FeatureTracks::clear() noexcept {
  std::fill(latest_us_.begin(), latest_us_.end(), kNever_us);
  set_gamma(1);
  oldest_stamp_ = 0;
  stamps_ = 0;
  clock_ = {};
  places_.clear();
  free_.clear();
  for (std::size_t slot = tracks_.size(); slot-- > 0;) free_.push_back(static_cast<Slot>(slot));
  oldest_ = kNone;
  newest_ = kNone;
  created_ = 0;
}

}  // namespace asap::inline v0_1
