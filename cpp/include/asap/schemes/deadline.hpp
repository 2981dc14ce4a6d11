// Deadline: as many events as possible within the latency bound L, counted from their arrival
// (live) or their stamp (a recording), and none later. A backlog that fits into the bound is taken
// whole. Otherwise the law plays a dozen plans forward on the backlog and takes the best
// (notebooks/theory.md, section 6). A plan is a package of some length T: it drops events older
// than L - T, thins the older part of the rest to the number that it can finish, and leaves the
// newest events in the ring. Its value is the work finished in time if arrivals stop and, in a
// rush, the work of such packages if they go on, less the price of a gap.
//
// There is no rate estimate and no integrator in the loop, so nothing lags. Called on the
// consumer's thread, once or twice per package. 32 counts by age and one exact one, no allocation.
// Where the bound is below what the algorithm needs at all, it plans with 2.5 fixed costs.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string_view>

#include "asap/schemes/bounded_scheme.hpp"

namespace asap {

// What matters more in overload where the two differ: the number of processed events, or that no
// long stretch of time (a gap) goes by without one.
enum class Prefer {
  balanced,    // a gap has a price; notebooks/theory.md, section 6, has the gaps that were measured
  events,      // a quarter of that price
  continuity,  // no gap where what waits allows it
};

// As it is written in Python and on the command line.
std::string_view name_of(Prefer prefer) noexcept;
// Throws std::invalid_argument for any other name.
Prefer prefer_of(std::string_view name);

struct DeadlineConfig {
  std::chrono::nanoseconds latency = kDefaultLatency;  // L, the one number that a user must know
  double overhead = 0.5;  // permitted share of fixed costs in the processor, 0 = any
  std::chrono::nanoseconds min_interval{};  // shortest time between package starts
  double first_alpha_us = 50.0;             // cost of a package before one has been seen
  double first_beta_ns = 100.0;             // cost of an event, likewise
  Prefer prefer = Prefer::balanced;

  static constexpr std::tuple kParameters{
      NamedField{"latency_ms", &DeadlineConfig::latency},
      NamedField{"overhead", &DeadlineConfig::overhead},
      NamedField{"min_interval_ms", &DeadlineConfig::min_interval},
      NamedField{"first_alpha_us", &DeadlineConfig::first_alpha_us},
      NamedField{"first_beta_ns", &DeadlineConfig::first_beta_ns},
      NamedField{"prefer", &DeadlineConfig::prefer},
  };
};

// The part of the latency bound that is left free for outages. On a busy machine the thread is
// taken off the processor for milliseconds, again and again; what is in work then ends as much too
// late, and no replanning makes up for an outage at the end of a package. So the scheme plans with
// a shorter bound: the reserve grows while more than a few in a thousand events are late, and
// shrinks while fewer are. Where outages are rare it is zero and costs nothing. It has no
// parameter. O(1) per package.
class OutageReserve {
 public:
  // A package ended with its oldest event latency_ns old, its newest span_ns less. bound_ns is what
  // can be kept: a cost that breaks the bound is no outage.
  void observe(double latency_ns, double span_ns, double bound_ns) noexcept {
    const double late_ns = latency_ns - bound_ns;
    const bool is_late = late_ns > kGrace * bound_ns;
    const double late = is_late ? std::min(late_ns / std::max(span_ns, 1.0), 1.0) : 0.0;
    share_ = std::clamp(share_ + kGain * (late - kTolerated), 0.0, kMax);
  }

  // The reserve of a bound; at most what leaves room for four fixed costs.
  double ns(double bound_ns, double alpha_ns) const noexcept {
    return std::clamp(bound_ns - 4.0 * alpha_ns, 0.0, share_ * bound_ns);
  }

 private:
  static constexpr double kGain = 0.05;   // step in bounds for a package that is late as a whole
  static constexpr double kGrace = 0.01;  // share of the bound below which lateness is no outage
  static constexpr double kTolerated = 0.005;  // so that p99 is within the bound
  static constexpr double kMax = 0.5;          // shorter packages cost more than they save

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
  double reachable_ns() const noexcept;
  double planned_ns() const noexcept;
  Decision take(const Backlog& backlog, double latency_ns, double length_ns, double size,
                double stay) noexcept;

  Decision newest_of(const Backlog& backlog, const Decision& slice, double latency_ns) noexcept;
  bool is_early() const noexcept;
  double caution() const noexcept;  // zeta, of events
  double fixed_caution(double latency_ns) const noexcept;
  double safe_size(double room_ns, double latency_ns, double enough) const noexcept;

  const DeadlineConfig config_;
  OutageReserve reserve_;
};

// The default scheme, for a program without exceptions.
inline Result<Deadline> make_scheme(const DeadlineConfig& config = {}) noexcept {
  return make_scheme<Deadline>(config);
}

}  // namespace asap
