#include "asap/schemes/deadline.hpp"

#include <algorithm>
#include <cmath>

#include "schemes/calibration.hpp"

namespace asap {
namespace {

constexpr double kAgeSlots = 64.0;      // per bound, as in the ring
constexpr double kLeastAgeNs = 1000.0;  // of a load
constexpr double kLongestBudgetNs = 1e18;
constexpr double kWholeCaution = 2.5;  // z: nothing stops a whole package that is late
constexpr double kReach = 2.5;         // fixed costs
constexpr std::uint64_t kSurePackages = 4;

double age_ns(const Backlog& backlog) noexcept {
  return static_cast<double>(std::max<std::int64_t>(backlog.age_ns(), 0));
}

double count(const Backlog& backlog) noexcept { return static_cast<double>(backlog.count); }

// Waiting events up to that age.
double younger(const Backlog& backlog, double age_ns) noexcept {
  const std::size_t older =
      backlog.counts.about_before(backlog.now_ns - static_cast<std::int64_t>(age_ns));
  return static_cast<double>(backlog.count - std::min(older, backlog.count));
}

}  // namespace

Deadline::Deadline(Config config)
    : BoundedScheme(
          config, {.first_alpha_us = config.first_alpha_us, .first_beta_ns = config.first_beta_ns}),
      config_(config) {
  reset(Execution::whole);
}

void Deadline::reset(Execution execution) noexcept {
  BoundedScheme::reset(execution);
  reserve_ = {};
  age_ns_ = 0.0;
}

Decision Deadline::decide(const Backlog& backlog) noexcept {
  const Limits limits = this->limits();
  if (const auto wait = hold_.wait(backlog, cost_, caution(), limits.latency_ns)) return *wait;
  if (const std::size_t stale = this->stale(backlog, limits); stale > 0) {
    return Decision::drop(stale);
  }
  age_ns_ = age_ns(backlog);
  const double room_ns = std::max(limits.latency_ns - age_ns_, 1.0);
  const Decision decision = plan(backlog, limits, room_ns);
  if (!is_whole()) return decision;
  return safe_slice(decision, safe_size(room_ns / caution(), cost_.most_event_ns()));
}

Decision Deadline::plan(const Backlog& backlog, const Limits& limits,
                        double room_ns) const noexcept {
  const double all = count(backlog);
  const double work_ns = caution() * cost_.predict_ns(all);
  const double budget_ns = std::min(limits.longest_ns, room_ns);
  const auto bound_ns = static_cast<double>(latency_bound_ns_.load());
  if (is_single(packages_, cost_.alpha_ns(), bound_ns)) return take(1.0, 1.0, budget_ns);
  if (work_ns <= budget_ns) return take(all, all, budget_ns);
  const Lengths lengths = this->lengths(backlog, limits, room_ns);
  if (work_ns <= lengths.package_ns) return take(all, all, lengths.package_ns);
  return thin(backlog, reserve(backlog, lengths, limits.latency_ns), lengths.package_ns);
}

// The bound; what two packages take that are little more than their fixed cost where that is more,
// but not on the strength of a first guess.
double Deadline::reachable_ns() const noexcept {
  const auto bound_ns = static_cast<double>(latency_bound_ns_.load());
  return is_early() ? bound_ns : std::max(bound_ns, kReach * cost_.alpha_ns());
}

Deadline::Limits Deadline::limits() const noexcept {
  const double alpha_ns = cost_.alpha_ns();
  double latency_ns = reachable_ns();
  latency_ns *= 1.0 - 0.05 * std::max(0.0, cost_.sigma() - 0.05);
  latency_ns -= reserve_.ns(latency_ns, alpha_ns);

  const double least_ns = std::min(hold_.min_interval_ns(), latency_ns / 2);
  double longest_ns = latency_ns / 2;
  if (is_whole()) {
    // Shorter, as nothing stops it, unless that would leave little but fixed costs.
    longest_ns = std::clamp(4.0 * caution() * alpha_ns, latency_ns / 3, longest_ns);
  }
  if (config_.knee > 0) {
    longest_ns = std::min(longest_ns, std::max(config_.knee * alpha_ns, latency_ns / 10));
  }
  longest_ns = std::max(longest_ns, least_ns);
  const double shortest_ns = std::max(std::sqrt(12.0 * alpha_ns * latency_ns), least_ns);
  return {latency_ns, longest_ns, std::min(longest_ns, shortest_ns)};
}

// None while the oldest event can still make it. Else all that is older than L - T_lo, so that
// there is time for a package afterwards.
std::size_t Deadline::stale(const Backlog& backlog, const Limits& limits) const noexcept {
  const double least_ns = std::min(1.5 * cost_.alpha_ns(), limits.latency_ns / 2);
  if (age_ns(backlog) + least_ns <= limits.latency_ns) return 0;
  const double keep_ns = limits.latency_ns - std::max(limits.shortest_ns, least_ns);
  const std::int64_t keep = static_cast<std::int64_t>(keep_ns);
  return std::min(backlog.counts.before(backlog.now_ns - keep), backlog.count);
}

Deadline::Lengths Deadline::lengths(const Backlog& backlog, const Limits& limits,
                                    double room_ns) const noexcept {
  const double latency_ns = limits.latency_ns;
  const double alpha_ns = cost_.alpha_ns();
  const double event_ns = caution() * cost_.beta_ns();
  const double recent_ns = latency_ns / 20;
  const double load_now = event_ns * younger(backlog, recent_ns) / recent_ns;
  const double load = event_ns * count(backlog) / std::max(age_ns(backlog), kLeastAgeNs);
  double length_ns = limits.shortest_ns;
  if (load > 1) length_ns = 0.9 * latency_ns * (load - 1.0) / (2.0 * load - 1.0);
  length_ns = std::clamp(length_ns, limits.shortest_ns, limits.longest_ns);
  const double in_time_ns = std::min(length_ns, room_ns);
  if (load_now >= 1 || !is_sure()) return {in_time_ns, length_ns};
  // The rush is over: the next packages will be short, and this one may use all the time there is.
  const double next_ns =
      std::min(length_ns, std::max(3.0 * alpha_ns, 2.0 * alpha_ns / (1.0 - load_now)));
  const bool is_long = !is_whole() && load_now <= 1.0 - 2.0 * alpha_ns / length_ns;
  return {is_long ? room_ns : in_time_ns, next_ns};
}

// How many of the youngest events stay behind: those up to the largest age x for which an event of
// any age a < x is still in time when this package and all that is older in the reserve are done.
double Deadline::reserve(const Backlog& backlog, const Lengths& lengths,
                         double latency_ns) const noexcept {
  const double beta_ns = cost_.beta_ns();
  const double time_ns = latency_ns - lengths.package_ns - 2.0 * cost_.alpha_ns();
  const double oldest_ns = std::min(latency_ns - lengths.next_ns - lengths.package_ns, time_ns);
  const double slot_ns = latency_ns / kAgeSlots;
  double lead_ns = 0.0;  // max over a of: a - beta #(age <= a)
  double left = 0.0;     // #(age <= x)
  for (double age_ns = 0.0; age_ns < oldest_ns;) {
    age_ns = std::min(age_ns + slot_ns, oldest_ns);
    const double next = younger(backlog, age_ns);
    if (beta_ns * next + lead_ns > time_ns) {
      return std::clamp((time_ns - lead_ns) / beta_ns, left, next);
    }
    left = next;
    lead_ns = std::max(lead_ns, age_ns - beta_ns * left);
  }
  return left;
}

Decision Deadline::thin(const Backlog& backlog, double reserve, double budget_ns) const noexcept {
  const double waiting = count(backlog);
  const double alpha_ns = cost_.alpha_ns();
  const double affordable_ns = std::max(budget_ns / caution() - alpha_ns, alpha_ns / 4.0);
  const double affordable = std::max(1.0, std::floor(affordable_ns / cost_.beta_ns()));
  const double raw = std::min(waiting, std::max(waiting - std::floor(reserve), affordable));
  return take(raw, std::min(raw, affordable), budget_ns);
}

Decision Deadline::take(double raw, double size, double budget_ns) const noexcept {
  const Decision decision = Decision::take(static_cast<std::size_t>(raw), size / raw);
  if (is_whole()) return decision;
  return within(std::clamp(budget_ns, 1.0, kLongestBudgetNs), decision);
}

void Deadline::observe(const Outcome& outcome) noexcept {
  const bool was_early = is_early();
  BoundedScheme::observe(outcome);
  if (outcome.size == 0 || was_early) return;  // the first guess may be to blame
  reserve_.observe(age_ns_ + static_cast<double>(outcome.processing_ns),
                   static_cast<double>(outcome.span_ns), reachable_ns());
}

bool Deadline::is_early() const noexcept { return asap::is_early(packages_); }

double Deadline::caution() const noexcept {
  return is_whole() ? 1.0 + kWholeCaution * cost_.sigma() : 1.0;
}

// Whether the cost model may be trusted with all the time there is. An anytime package ends on time
// even if it may not, so a few packages will do.
bool Deadline::is_sure() const noexcept {
  return is_whole() ? !is_early() : packages_ >= kSurePackages;
}

}  // namespace asap
