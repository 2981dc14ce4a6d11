// WindowClusterer: event-by-event clustering over one window of the last S events, as published. An
// event joins the oldest-created cluster whose centre, or one of whose randomly probed events, lies
// within R (L1), merges all others that pass, or founds a cluster. One thread. update() is O(1), a
// merge O(events of the smaller one); allocates in the constructor only. Source: Rodriguez-Gomez et
// al., ICRA 2020; their release forgets by time and remembers more where timestamps are equal.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <utility>
#include <vector>

#include "algorithms/cell_grid.hpp"
#include "algorithms/centre_grid.hpp"
#include "algorithms/event_window.hpp"
#include "algorithms/probe_index.hpp"
#include "algorithms/window_moments.hpp"
#include "asap/algorithms/cluster_tracker.hpp"
#include "asap/algorithms/published_cluster_tracker.hpp"
#include "asap/core/event.hpp"

namespace asap::inline v0_1 {

template <class Sampler = UniformProbe>
class WindowClusterer {
 public:
  using Slot = CentreGrid::Slot;
  using Position = EventWindow::Position;
  using Cell = CellGrid::Cell;
  static constexpr std::int32_t kNoId = -1;

  struct alignas(64) State {
    double x;  // px, the centre of the rule: an exponential mean. Reported is the centroid.
    double y;
    WindowMoments moments;
    std::uint64_t created;  // number of creation: smaller is older
    std::int32_t id;
    Position newest;      // event: the way into the chain
    ProbeIndex::Key key;  // key in the probe index, or kSmall or kKeyless
  };

  // Precondition: the configuration is checked.
  WindowClusterer(const PublishedClusterTrackerConfig& config, Sampler sampler)
      : radius_(config.radius),
        reach_(static_cast<int>(std::min(config.radius, 0x1p20))),
        probes_(static_cast<std::uint64_t>(config.probes)),
        weight_(config.weight),
        min_size_(static_cast<std::uint64_t>(config.min_size)),
        key_size_(static_cast<std::uint64_t>(std::max(config.min_size - kHysteresis, 0))),
        sampler_(std::move(sampler)),
        grid_(config.width, config.height, config.radius),
        window_(static_cast<std::size_t>(config.window)),
        centres_(grid_.size(), window_.capacity()),
        index_(probes_ > 0 ? grid_.size() : 0, probes_ > 0 ? window_.capacity() : 0),
        states_(window_.capacity()) {
    free_.reserve(states_.size());
    assigned_.reserve(states_.size());
    keyless_.reserve(states_.size());
    clear();
  }

  // Takes one event; returns its cluster. Precondition: the pixel lies in the frame.
  Slot update(const Event& event) noexcept {
    if (window_.full()) forget_oldest();
    const Cell cell = grid_.cell(event.x, event.y);
    assign(event, cell);
    const Slot slot = assigned_.empty() ? found(event, cell) : join(event, cell);
    ++events_;

    State& state = states_[slot];
    if (state.id == kNoId && size_of(state) >= min_size_) state.id = issue_id();
    if (probes_ > 0 && state.key == kSmall && size_of(state) > min_size_) enter_index(slot);
    return slot;
  }

  // Precondition: the cluster has events.
  const State& operator[](Slot slot) const noexcept { return states_[slot]; }

  // Number of clusters that have events.
  std::size_t live() const noexcept { return states_.size() - free_.size(); }

  // The clusters of at least min_size events, by id. Allocates only where `clusters` must grow.
  void read(std::vector<Cluster>& clusters) const {
    clusters.clear();
    for (std::size_t slot = 0; slot < used_; ++slot) {
      const State& state = states_[slot];
      if (size_of(state) == 0 || size_of(state) < min_size_) continue;
      clusters.push_back(report(state));
    }
    std::sort(clusters.begin(), clusters.end(),
              [](const Cluster& a, const Cluster& b) { return a.id < b.id; });
  }

  // Back to the state after construction.
  void clear() noexcept {
    sampler_.clear();
    window_.clear();
    centres_.clear();
    index_.clear();
    keyless_.clear();
    free_.clear();
    for (std::size_t slot = states_.size(); slot-- > 0;) {
      states_[slot].moments = {};
      free_.push_back(static_cast<Slot>(slot));
    }
    used_ = 0;
    events_ = 0;
    created_ = 0;
    next_id_ = 0;
  }

 private:
  // A cluster is big, and so probed, beyond min_size events. It enters the probe index then, and
  // leaves it kHysteresis events after it has ceased to be big: one that hovers does not pay.
  static constexpr int kHysteresis = 5;
  static constexpr ProbeIndex::Key kSmall = ProbeIndex::kNoKey;
  static constexpr ProbeIndex::Key kKeyless = kSmall - 1;  // big, but the index was full

  static std::uint64_t size_of(const State& state) noexcept { return state.moments.count(); }

  bool is_near(const State& state, const Event& event) const noexcept {
    return std::abs(event.x - state.x) + std::abs(event.y - state.y) <= radius_;
  }

  bool is_near(Position position, const Event& event) const noexcept {
    const EventWindow::Entry& entry = window_[position];
    return std::abs(event.x - entry.x) + std::abs(event.y - entry.y) <= reach_;
  }

  // The cell of a centre, rounded to a pixel. A centre is a mean of pixels: it stays in the frame.
  Cell cell_of(const State& state) const noexcept {
    return grid_.cell(static_cast<std::size_t>(state.x + 0.5),
                      static_cast<std::size_t>(state.y + 0.5));
  }

  // ---- forgetting ----

  void forget_oldest() noexcept {
    const Position oldest = window_.cursor();
    const EventWindow::Entry& entry = window_[oldest];
    State& state = states_[entry.cluster];
    window_.unchain(oldest);
    state.moments.remove(entry.x, entry.y, entry.t);
    if (state.key >= 0) index_.remove(state.key, entry.cell, oldest);
    if (size_of(state) <= key_size_ && state.key != kSmall) leave_index(entry.cluster);
    if (size_of(state) == 0) erase(entry.cluster);
  }

  void erase(Slot slot) noexcept {
    centres_.leave(slot);
    free_.push_back(slot);
  }

  // ---- assignment ----

  // Fills assigned_ with the clusters that the event belongs to, oldest-created first.
  void assign(const Event& event, Cell cell) noexcept {
    assigned_.clear();
    grid_.for_each_around(cell, [&](std::size_t c) {
      for (Slot slot = centres_.first(c); slot != CentreGrid::kNone; slot = centres_.next(slot)) {
        if (is_near(states_[slot], event)) add_assigned(slot);
      }
    });
    if (probes_ == 0) return;
    index_.near(grid_, cell).for_each([&](ProbeIndex::Key key) {
      try_probe(index_.owner(key), event);
    });
    for (const Slot slot : keyless_) try_probe(slot, event);
  }

  void add_assigned(Slot slot) noexcept {
    auto place = assigned_.size();
    assigned_.push_back(slot);
    for (; place > 0 && states_[slot].created < states_[assigned_[place - 1]].created; --place) {
      assigned_[place] = assigned_[place - 1];
    }
    assigned_[place] = slot;
  }

  void try_probe(Slot slot, const Event& event) noexcept {
    const State& state = states_[slot];
    if (size_of(state) <= min_size_ || is_near(state, event)) return;
    if (probe_hits(state, event)) add_assigned(slot);
  }

  bool probe_hits(const State& state, const Event& event) noexcept {
    if (probes_ > size_of(state)) return any_near(state, event);
    for (std::uint64_t probe = 0; probe < probes_; ++probe) {
      const Position drawn = sampler_(ProbeDraw{events_, state.created, probe}, size_of(state),
                                      [&](std::uint64_t i) { return member(state, i); });
      if (is_near(drawn, event)) return true;
    }
    return false;
  }

  bool any_near(const State& state, const Event& event) const noexcept {
    bool any = false;
    window_.for_each(state.newest, [&](Position position) { any |= is_near(position, event); });
    return any;
  }

  // Live event i of a cluster, in no particular order.
  Position member(const State& state, std::uint64_t i) const noexcept {
    if (state.key >= 0) return index_.member(state.key, i);
    // More clusters are big than the index has keys: their chains are short.
    Position position = state.newest;
    while (i-- > 0) position = window_[position].next;
    return position;
  }

  // ---- update ----

  Slot found(const Event& event, Cell cell) noexcept {
    const Slot slot = free_.back();
    free_.pop_back();
    used_ = std::max(used_, slot + std::size_t{1});
    State& state = states_[slot];
    state.x = event.x;
    state.y = event.y;
    state.moments.add(event.x, event.y, event.t);
    state.created = created_++;
    state.id = kNoId;
    state.newest = window_.append(event, cell, slot);
    state.key = kSmall;
    centres_.enter(slot, cell);
    return slot;
  }

  // Adds the event to the oldest-created of the assigned clusters, then makes one cluster of them.
  Slot join(const Event& event, Cell cell) noexcept {
    const Slot first = assigned_.front();
    State& state = states_[first];
    state.x = (1 - weight_) * state.x + weight_ * event.x;
    state.y = (1 - weight_) * state.y + weight_ * event.y;
    state.moments.add(event.x, event.y, event.t);
    const Position position = window_.append(event, cell, first);
    window_.join(position, state.newest);
    state.newest = position;
    if (state.key >= 0) index_.add(state.key, cell, position);

    const Slot slot = assigned_.size() == 1 ? first : merge_assigned(position);
    centres_.move(slot, cell_of(states_[slot]));
    return slot;
  }

  // Returns the slot of the one that is left.
  Slot merge_assigned(Position newest) noexcept {
    // The published order is that of creation: rounding could flip a later comparison with R.
    double total = 0;
    for (const Slot slot : assigned_) total += static_cast<double>(size_of(states_[slot]));
    double x = 0;
    double y = 0;
    for (const Slot slot : assigned_) {
      const double share = static_cast<double>(size_of(states_[slot])) / total;
      x += share * states_[slot].x;
      y += share * states_[slot].y;
    }

    Slot left = assigned_.front();
    for (std::size_t i = 1; i < assigned_.size(); ++i) left = absorb(left, assigned_[i]);
    State& state = states_[left];
    state.x = x;
    state.y = y;
    state.newest = newest;
    return left;
  }

  // Makes one cluster of two, relabelling the smaller; the seniority of the older is kept.
  Slot absorb(Slot older, Slot younger) noexcept {
    const bool older_is_larger = size_of(states_[older]) >= size_of(states_[younger]);
    const Slot kept = older_is_larger ? older : younger;
    const Slot gone = older_is_larger ? younger : older;
    State& to = states_[kept];
    State& from = states_[gone];

    if (from.key != kSmall) leave_index(gone);
    window_.for_each(from.newest, [&](Position position) {
      window_[position].cluster = kept;
      if (to.key >= 0) index_.add(to.key, window_[position].cell, position);
    });
    window_.join(to.newest, from.newest);
    to.created = states_[older].created;
    to.id = smaller_id(to.id, from.id);
    to.moments += from.moments;
    from.moments = {};
    erase(gone);
    return kept;
  }

  static std::int32_t smaller_id(std::int32_t a, std::int32_t b) noexcept {
    if (a == kNoId || b == kNoId) return std::max(a, b);
    return std::min(a, b);
  }

  // Ids are 31 bits, as labels are; after 2^31 of them they begin again.
  std::int32_t issue_id() noexcept {
    const std::int32_t id = next_id_;
    next_id_ = static_cast<std::int32_t>((static_cast<std::uint32_t>(id) + 1) & 0x7fffffffU);
    return id;
  }

  // ---- probe index ----

  void enter_index(Slot slot) noexcept {
    State& state = states_[slot];
    state.key = index_.acquire(slot);
    if (state.key == ProbeIndex::kNoKey) {
      state.key = kKeyless;
      keyless_.push_back(slot);
      return;
    }
    window_.for_each(state.newest, [&](Position position) {
      index_.add(state.key, window_[position].cell, position);
    });
  }

  void leave_index(Slot slot) noexcept {
    State& state = states_[slot];
    if (state.key == kKeyless) {
      *std::find(keyless_.begin(), keyless_.end(), slot) = keyless_.back();
      keyless_.pop_back();
    } else {
      index_.release(state.key, [&](Position position) { return window_[position].cell; });
    }
    state.key = kSmall;
  }

  // ---- read-out ----

  Cluster report(const State& state) const noexcept {
    const Vector2 centroid = state.moments.centroid();
    const Covariance covariance = state.moments.covariance();
    const Vector2 velocity = chain_velocity(window_, state.newest, state.moments);
    return {.id = state.id,
            .x = centroid.x,
            .y = centroid.y,
            .vx = velocity.x * 1e6,
            .vy = velocity.y * 1e6,
            .cxx = covariance.xx,
            .cxy = covariance.xy,
            .cyy = covariance.yy,
            .size = static_cast<std::int64_t>(size_of(state)),
            .t_last = window_[state.newest].t};
  }

  double radius_;
  int reach_;  // px, the radius between two pixels
  std::uint64_t probes_;
  double weight_;
  std::uint64_t min_size_;
  std::uint64_t key_size_;  // size down to which a key is kept
  Sampler sampler_;
  CellGrid grid_;
  EventWindow window_;
  CentreGrid centres_;
  ProbeIndex index_;
  std::vector<State> states_;
  std::vector<Slot> free_;
  std::vector<Slot> assigned_;  // clusters that take the event in hand
  std::vector<Slot> keyless_;   // big clusters that found the index full
  std::size_t used_ = 0;        // slots from here on were never used
  std::uint64_t events_ = 0;
  std::uint64_t created_ = 0;
  std::int32_t next_id_ = 0;
};

}  // namespace asap::inline v0_1
