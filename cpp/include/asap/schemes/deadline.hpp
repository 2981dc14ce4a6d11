// Deadline: as many events as possible within the latency bound L of their stamps, and none later.
// The reservoir law (notebooks/theory.md, section 6): when more waits than can be finished in time,
// only the older head of the backlog is thinned and executed. The newest events stay behind raw,
// exactly as much work as could still be finished in time if arrivals stopped now; so when a rush
// ends, there is something left to serve. A package of length T that leaves events up to age x
// behind must satisfy 2T + x <= L.
//
// There is no rate estimate and no integrator in the loop, so nothing lags. Called on the
// consumer's thread, once or twice per package. At most 64 counts by age and one exact one, no
// allocation. Where the bound is below what the algorithm needs at all, it plans with 2.5 fixed
// costs.
#pragma once

#include <algorithm>

#include "asap/schemes/bounded_scheme.hpp"

namespace asap {

struct DeadlineConfig {
  double latency_ms = 10.0;      // L, the one number that a user must know
  double overhead = 0.25;        // permitted share of fixed costs in the processor, 0 = any
  double min_interval_ms = 0.0;  // shortest time between package starts
  double knee = 0.0;             // K: no package longer than K alpha (or L / 10), 0 = L / 2
  double first_alpha_us = 50.0;  // cost of a package before one has been seen
  double first_beta_ns = 100.0;  // cost of an event, likewise

  static constexpr std::tuple kParameters{
      NamedField{"latency_ms", &DeadlineConfig::latency_ms},
      NamedField{"overhead", &DeadlineConfig::overhead},
      NamedField{"min_interval_ms", &DeadlineConfig::min_interval_ms},
      NamedField{"knee", &DeadlineConfig::knee},
      NamedField{"first_alpha_us", &DeadlineConfig::first_alpha_us},
      NamedField{"first_beta_ns", &DeadlineConfig::first_beta_ns},
  };
};

// The part of the latency bound that is left free for outages. On a busy machine the thread is
// taken off the processor for milliseconds, again and again; what is in work then ends as much too
// late, and no replanning makes up for an outage at the end of a package. So the scheme plans with
// a shorter bound where more than a few in a thousand events have come late: each package moves the
// reserve by its late share less what is tolerated, until the late share settles there. Where
// outages are rare there is no reserve, nor is it paid for. Without a parameter. O(1) per package.
class OutageReserve {
 public:
  // A package ended with its oldest event latency_ns old, its newest span_ns less. bound_ns is what
  // can be kept: a cost that breaks the bound is no outage.
  void observe(double latency_ns, double span_ns, double bound_ns) noexcept {
    const double late_ns = latency_ns - bound_ns;
    const bool is_late = late_ns > kGrace * bound_ns;
    const double late = is_late ? std::min(late_ns / std::max(span_ns, 1.0), 1.0) : 0.0;
    share_ = std::clamp(share_ + kGain * (late - kTolerated), 0.0, kMost);
  }

  // The reserve of a bound; at most what leaves room for four fixed costs.
  double ns(double bound_ns, double alpha_ns) const noexcept {
    return std::clamp(bound_ns - 4.0 * alpha_ns, 0.0, share_ * bound_ns);
  }

 private:
  static constexpr double kGain = 0.05;        // of a bound, for a package that is late as a whole
  static constexpr double kGrace = 0.01;       // of a bound: less than that is no outage
  static constexpr double kTolerated = 0.005;  // so that p99 is within the bound
  static constexpr double kMost = 0.5;         // shorter packages cost more than they save

  double share_ = 0.0;
};

class Deadline final : public BoundedScheme {
 public:
  using Config = DeadlineConfig;

  explicit Deadline(Config config = {});

  Decision decide(const Backlog& backlog) noexcept override;
  void observe(const Outcome& outcome) noexcept override;
  void reset(Execution execution) noexcept override;
  std::string_view name() const noexcept override { return "deadline"; }
  SchemeParameters parameters() const override { return parameters_in_force(config_); }

 private:
  // What the present estimates allow.
  struct Limits {
    double latency_ns;   // L, less a margin for noise and one for outages
    double longest_ns;   // T_hi, of a package
    double shortest_ns;  // T_lo, of a package in overload
  };
  struct Lengths {
    double package_ns;  // H, of this package
    double next_ns;     // T_n, of the next one
  };

  double reachable_ns() const noexcept;
  Limits limits() const noexcept;
  std::size_t stale(const Backlog& backlog, const Limits& limits) const noexcept;
  Decision plan(const Backlog& backlog, const Limits& limits, double room_ns) const noexcept;
  Lengths lengths(const Backlog& backlog, const Limits& limits, double room_ns) const noexcept;
  double reserve(const Backlog& backlog, const Lengths& lengths, double latency_ns) const noexcept;
  Decision thin(const Backlog& backlog, double reserve, double budget_ns) const noexcept;
  Decision take(double raw, double size, double budget_ns) const noexcept;

  bool is_early() const noexcept;
  bool is_sure() const noexcept;
  double caution() const noexcept;  // zeta

  const DeadlineConfig config_;
  OutageReserve reserve_;
  double age_ns_;  // of the oldest event, when the last package was taken
};

}  // namespace asap
