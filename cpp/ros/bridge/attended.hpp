// Attended: Deadline, but while the consumer stays away little is published, the rest is dropped as
// stale, and what a package takes is no cost of the algorithm.
//
// One thread, that of the run.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <utility>

#include "asap/schemes/deadline.hpp"

namespace asap::ros {

class Attended final : public Scheme {
 public:
  // Events of a package while the consumer stays away: the middleware keeps them for it.
  static constexpr std::size_t kWhileAway = 1'000;

  explicit Attended(const DeadlineConfig& config) : law_(config) {}

  // At the end of each package, before its outcome is known.
  void note(bool is_away) noexcept { was_away_ = std::exchange(is_away_, is_away); }

  Decision decide(const Backlog& backlog) noexcept override {
    const bool is_much = is_away_ && backlog.count > kWhileAway;
    return is_much ? Decision::drop(backlog.count - kWhileAway) : law_.decide(backlog);
  }
  void observe(const Outcome& outcome) noexcept override {
    if (!is_away_ && !was_away_) law_.observe(outcome);
  }
  void reset(Execution execution) noexcept override { law_.reset(execution); }
  std::string_view name() const noexcept override { return law_.name(); }
  std::int64_t latency_bound_ns() const noexcept override { return law_.latency_bound_ns(); }
  void set_latency_bound_ns(std::int64_t ns) noexcept override { law_.set_latency_bound_ns(ns); }

  const Deadline& law() const noexcept { return law_; }

 private:
  Deadline law_;
  bool is_away_ = false, was_away_ = false;  // at the end of the last package and the one before
};

}  // namespace asap::ros
