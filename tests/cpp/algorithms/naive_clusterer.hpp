// The published clustering rule, written down as it stands: vectors, no index, every cluster looked
// at for every event. The oracle of WindowClusterer and its rival in the benchmark. As there, the
// window is exactly the last S events.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "algorithms/probe_index.hpp"
#include "asap/algorithms/published_cluster_tracker.hpp"
#include "asap/core/event.hpp"

namespace asap::test {

template <class Sampler = UniformProbe>
class NaiveClusterer {
 public:
  struct Member {
    std::uint64_t number;
    Event event;
  };

  struct State {
    double x;
    double y;
    std::uint64_t created;
    std::int32_t id;
    std::vector<Member> members;  // in time order
  };

  NaiveClusterer(const PublishedClusterTrackerConfig& config, Sampler sampler)
      : config_(config), sampler_(std::move(sampler)) {}

  // Returns the cluster that took the event; valid until the next event.
  const State& update(const Event& event) {
    const std::uint64_t number = events_++;
    forget(number);

    std::vector<std::size_t> assigned;
    for (std::size_t i = 0; i < clusters_.size(); ++i) {
      if (belongs(clusters_[i], event, number)) assigned.push_back(i);
    }
    if (assigned.empty()) {
      clusters_.push_back({static_cast<double>(event.x),
                           static_cast<double>(event.y),
                           created_++,
                           -1,
                           {{number, event}}});
      return labelled(clusters_.back());
    }
    State& first = clusters_[assigned[0]];
    first.x = (1 - config_.weight) * first.x + config_.weight * event.x;
    first.y = (1 - config_.weight) * first.y + config_.weight * event.y;
    first.members.push_back({number, event});
    if (assigned.size() >= 2) merge(assigned);
    return labelled(first);
  }

  const std::vector<State>& clusters() const { return clusters_; }

 private:
  void forget(std::uint64_t number) {
    const auto window = static_cast<std::uint64_t>(config_.window);
    for (State& c : clusters_) {
      std::erase_if(c.members, [&](const Member& m) { return m.number + window <= number; });
    }
    std::erase_if(clusters_, [](const State& c) { return c.members.empty(); });
  }

  bool is_near(double x, double y, const Event& event) const {
    return std::abs(event.x - x) + std::abs(event.y - y) <= config_.radius;
  }

  bool belongs(const State& c, const Event& event, std::uint64_t number) {
    if (is_near(c.x, c.y, event)) return true;
    const std::size_t n = c.members.size();
    if (n <= static_cast<std::size_t>(config_.min_size)) return false;
    const auto probes = static_cast<std::uint64_t>(config_.probes);
    const auto hits = [&](const Member& m) { return is_near(m.event.x, m.event.y, event); };
    if (probes > n) {
      for (const Member& m : c.members) {
        if (hits(m)) return true;
      }
      return false;
    }
    for (std::uint64_t k = 0; k < probes; ++k) {
      const std::size_t drawn = sampler_(ProbeDraw{number, c.created, k}, n, [](std::uint64_t i) {
        return static_cast<std::size_t>(i);
      });
      if (hits(c.members[drawn])) return true;
    }
    return false;
  }

  void merge(const std::vector<std::size_t>& assigned) {
    std::size_t total = 0;
    for (const std::size_t i : assigned) total += clusters_[i].members.size();
    double x = 0;
    double y = 0;
    std::vector<Member> members;
    std::int32_t id = -1;
    for (const std::size_t i : assigned) {
      const State& c = clusters_[i];
      const double share = static_cast<double>(c.members.size()) / static_cast<double>(total);
      x += share * c.x;
      y += share * c.y;
      members.insert(members.end(), c.members.begin(), c.members.end());
      if (c.id >= 0 && (id < 0 || c.id < id)) id = c.id;
    }
    std::sort(members.begin(), members.end(),
              [](const Member& a, const Member& b) { return a.number < b.number; });
    State& first = clusters_[assigned[0]];
    first.x = x;
    first.y = y;
    first.id = id;
    first.members = std::move(members);
    for (std::size_t i = assigned.size(); i-- > 1;) {
      clusters_.erase(clusters_.begin() + static_cast<std::ptrdiff_t>(assigned[i]));
    }
  }

  const State& labelled(State& c) {
    if (c.id < 0 && c.members.size() >= static_cast<std::size_t>(config_.min_size)) c.id = ids_++;
    return c;
  }

  PublishedClusterTrackerConfig config_;
  Sampler sampler_;
  std::vector<State> clusters_;  // in order of creation
  std::uint64_t events_ = 0;
  std::uint64_t created_ = 0;
  std::int32_t ids_ = 0;
};

}  // namespace asap::test
