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

#include "asap/schemes/bounded_scheme.hpp"
#include "asap/schemes/outage_reserve.hpp"

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
