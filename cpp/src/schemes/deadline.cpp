#include "asap/schemes/deadline.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include "core/check.hpp"
#include "schemes/bounded_scheme.hpp"
#include "schemes/calibration.hpp"
#include "schemes/outage_reserve.hpp"
#include "schemes/work_by_age.hpp"

namespace asap::inline v0_1 {
namespace {

constexpr std::array<std::string_view, 3> kPreferences{"balanced", "events", "continuity"};

constexpr double kMaxBudgetNs = 1e18;
constexpr double kAll = std::numeric_limits<double>::infinity();
constexpr double kCaution = 3.0;     // z: nothing stops a whole package that is late
constexpr double kSlack = 0.5;       // bounds: the most that z fixed costs may take
constexpr double kGrowth = 6.0;      // packages that sizes take from one event to thousands
constexpr double kNewest = 0.125;    // share of a package's time whose events may fill the next
constexpr double kReach = 2.5;       // fixed costs: a shorter bound is planned as this long
constexpr int kLengths = 8;          // that are tried, besides two that fit what waits
constexpr int kRollOut = 3;          // packages that are played forward after this one
constexpr double kHorizon = 6.0;     // bounds for which a rush goes on
constexpr double kRecent = 0.1;      // of a bound: what has come in it tells a rush
constexpr double kCheap = 2.0;       // fixed costs: work that is not worth dropping events for
constexpr int kRounds = 3;           // until a package and what it can keep agree
constexpr double kDearest = 50.0;    // fixed costs per bound from which on a gap has its full price
constexpr std::uint64_t kFirst = 6;  // packages, until the first guess of the cost is forgotten
constexpr std::uint64_t kTells = 8;  // packages, until fixed cost and cost per event are known

// The price of a gap as long as the bound, as a share of the throughput.
double gap_price(Prefer prefer) noexcept {
  switch (prefer) {
    case Prefer::events:
      return 0.05;
    case Prefer::continuity:
      return 1.0;
    default:
      return 0.2;
  }
}

double age_ns(const Backlog& backlog) noexcept {
  return static_cast<double>(std::max<std::int64_t>(backlog.age_ns(), 0));
}

// A package of length T, drawn up for what waits.
struct Plan {
  double length_ns = 0.0;  // T: events older than L - T are dropped
  double work_ns = 0.0;    // of the events that it keeps
  double stay_ns = 0.0;    // x: events up to this age stay behind
  double value_ns = -std::numeric_limits<double>::infinity();  // work in time less fixed costs
};

// What a plan is drawn up for. Times in ns.
struct Situation {
  double latency_ns;   // L, as planned with
  double caution;      // zeta: events are planned to take that times their cost
  double fixed_ns;     // a, of a package
  double slow_ns;      // the same with caution
  double event_ns;     // b, of an event
  double age_ns;       // A, of the oldest event
  double shortest_ns;  // of a package
  double longest_ns;   // likewise
  bool is_new;         // a rush cannot be told yet
  Prefer prefer;
};

// Plays plans forward on what waits.
class Planner {
 public:
  Planner(const WorkByAge& work, const Situation& now) noexcept
      : work_(work),
        latency_ns_(now.latency_ns),
        caution_(now.caution),
        fixed_ns_(now.fixed_ns),
        slow_ns_(now.slow_ns),
        event_ns_(now.event_ns),
        age_ns_(now.age_ns),
        shortest_ns_(now.shortest_ns),
        longest_ns_(std::max(shortest_ns_, longest_ns(now))),
        is_rush_(now.is_new || work.up_to(kRecent * latency_ns_) >= kRecent * latency_ns_),
        is_continuous_(now.prefer == Prefer::continuity),
        gap_price_(gap_price(now.prefer)) {
    if (!is_continuous_) gap_price_ *= std::min(1.0, latency_ns_ / (kDearest * fixed_ns_));
  }

  // The best plan; without work if nothing that waits can be finished in time.
  Plan best() const noexcept {
    Plan best{.length_ns = shortest_ns_};
    for (int i = 1; i <= kLengths; ++i) compare(0.98 * latency_ns_ * i / kLengths, best);
    compare(latency_ns_ - age_ns_, best);                  // drops nothing
    compare(work_.newest_only(slow_ns_, caution_), best);  // leaves nothing behind
    if (best.work_ns <= 0.0) compare(shortest_ns_, best);  // there was none in between
    return best;
  }

 private:
  void compare(double length_ns, Plan& best) const noexcept {
    if (length_ns < shortest_ns_ || length_ns > longest_ns_) return;
    Plan plan = drawn_up(length_ns);
    if (plan.work_ns <= 0.0) return;
    plan.value_ns = if_they_stop(plan) + (is_rush_ ? if_they_go_on(plan) : 0.0);
    if (plan.value_ns > best.value_ns) best = plan;
  }

  // Without a gap: two packages per bound, and none that must drop what still can make it.
  static double longest_ns(const Situation& now) noexcept {
    if (now.prefer != Prefer::continuity) return now.longest_ns;
    const double room_ns = now.latency_ns - now.age_ns;
    return std::min(now.latency_ns / 2, room_ns < now.shortest_ns ? now.latency_ns : room_ns);
  }

  // Fills the package first. What stays behind can still be finished: alone if no more events come,
  // else within the next package of like length or within three fixed costs.
  Plan drawn_up(double length_ns) const noexcept {
    const double left_ns = latency_ns_ - length_ns;
    const double there_ns = work_.up_to(left_ns);
    const double work_ns = std::min((length_ns - slow_ns_) / caution_, there_ns);
    double next_ns = is_rush_ ? fixed_ns_ : std::min(length_ns, 3.0 * fixed_ns_);
    if (is_rush_ && is_continuous_) next_ns = length_ns;
    const double stay_ns = std::min({work_.age_done_within(left_ns - 2.0 * fixed_ns_),
                                     left_ns - next_ns, work_.age_of(there_ns - work_ns)});
    return {.length_ns = length_ns, .work_ns = work_ns, .stay_ns = std::max(stay_ns, 0.0)};
  }

  // The package, and then what has stayed, oldest first, in packages as long as the bound allows.
  double if_they_stop(const Plan& plan) const noexcept {
    double value_ns = plan.work_ns - fixed_ns_;
    double now_ns = fixed_ns_ + plan.work_ns;
    double oldest_ns = plan.stay_ns;
    double left_ns = work_.up_to(oldest_ns);
    double size_ns = plan.work_ns;
    for (int k = 0; k < kRollOut && left_ns >= event_ns_; ++k) {
      const double room_ns = latency_ns_ - now_ns - oldest_ns;
      if (slow_ns_ + caution_ * left_ns <= room_ns) return value_ns + left_ns - fixed_ns_;
      const double length_ns = std::max(room_ns, 6.0 * slow_ns_);
      oldest_ns = std::min(oldest_ns, latency_ns_ - now_ns - length_ns);  // the rest is too old
      left_ns = work_.up_to(oldest_ns);
      size_ns = std::min(left_ns, (length_ns - slow_ns_) / caution_);
      if (size_ns <= 0.0) return value_ns;
      value_ns += size_ns - fixed_ns_;
      now_ns += fixed_ns_ + size_ns;
      left_ns -= size_ns;
      oldest_ns = work_.age_of(left_ns);
    }
    return left_ns >= event_ns_ ? value_ns + left_ns * (0.9 - fixed_ns_ / size_ns) : value_ns;
  }

  // Packages like this one for the horizon. The gap is what is dropped now, and before the next.
  double if_they_go_on(const Plan& plan) const noexcept {
    const double now_ns = std::max(0.0, age_ns_ + plan.length_ns - latency_ns_);
    const double next_ns = std::max(0.0, plan.stay_ns + 2.0 * plan.length_ns - latency_ns_);
    const double gap = (now_ns + next_ns) / latency_ns_;
    const double throughput = plan.work_ns / (fixed_ns_ + plan.work_ns);
    return kHorizon * latency_ns_ * (throughput - gap_price_ * gap * gap);
  }

  const WorkByAge& work_;
  const double latency_ns_;
  const double caution_;
  const double fixed_ns_;
  const double slow_ns_;
  const double event_ns_;
  const double age_ns_;
  const double shortest_ns_;
  const double longest_ns_;
  const bool is_rush_;  // what comes now is more than can be worked off
  const bool is_continuous_;
  double gap_price_;
};

}  // namespace

std::string_view name_of(Prefer prefer) noexcept {
  return kPreferences.at(static_cast<std::size_t>(prefer));
}

Prefer prefer_of(std::string_view name) {
  const auto found = std::find(kPreferences.begin(), kPreferences.end(), name);
  if (found == kPreferences.end()) {
    throw_bad_value("prefer", '"' + std::string(name) + '"',
                    R"(must be "balanced", "events" or "continuity")");
  }
  return static_cast<Prefer>(found - kPreferences.begin());
}

namespace {

class DeadlineLaw final : public BoundedScheme {
 public:
  explicit DeadlineLaw(DeadlineConfig config);

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

  std::optional<Decision> try_all(const Backlog& backlog, const WorkByAge& work,
                                  double latency_ns) noexcept;
  Decision newest_of(const Backlog& backlog, const Decision& slice, double latency_ns) noexcept;
  bool is_early() const noexcept;
  double caution() const noexcept;  // zeta, of events
  double fixed_caution(double latency_ns) const noexcept;
  double safe_size(double room_ns, double latency_ns, double enough) const noexcept;

  const DeadlineConfig config_;
  OutageReserve reserve_;
};

DeadlineLaw::DeadlineLaw(DeadlineConfig config)
    : BoundedScheme(
          config, {.first_alpha_us = config.first_alpha_us, .first_beta_ns = config.first_beta_ns}),
      config_(config) {
  require_known(config.prefer, Prefer::continuity, "prefer");
  reset(Execution::whole);
}

void DeadlineLaw::reset(Execution execution) noexcept {
  BoundedScheme::reset(execution);
  reserve_ = {};
}

Decision DeadlineLaw::decide(const Backlog& backlog) noexcept {
  const double latency_ns = planned_ns();
  const double zeta = caution();
  if (const auto wait = hold_.wait(backlog, cost_, zeta, latency_ns)) return *wait;
  const auto bound_ns = static_cast<double>(latency_bound_ns_.load());
  const double room_ns = latency_ns - age_ns(backlog);
  const double alpha_ns = cost_.alpha_ns();
  const double slow = fixed_caution(latency_ns);
  const double slow_ns = std::min(slow * alpha_ns, 0.4 * latency_ns);
  const double shortest_ns = 1.5 * slow_ns;
  if (!cost_.knows_alpha() && probe_.is_due(packages_, alpha_ns, bound_ns)) {
    return take(backlog, latency_ns, std::max(room_ns, shortest_ns), 1.0, kAll);
  }
  // Nothing stops a whole package that is late: a shorter one is less late.
  const double max_ns = is_whole() ? std::max(latency_ns / 2, 12.0 * slow_ns) : latency_ns;
  const double fit_ns = std::min(room_ns, max_ns);
  const auto all = static_cast<double>(backlog.count);
  const double event_ns = cost_.beta_ns();
  if (slow * alpha_ns + zeta * event_ns * all <= fit_ns) {
    return take(backlog, latency_ns, fit_ns, all, 0.0);
  }

  const WorkByAge work(backlog, latency_ns, event_ns);
  if (const auto tried = try_all(backlog, work, latency_ns)) return *tried;
  const Plan plan =
      Planner(work, {.latency_ns = latency_ns,
                     .caution = zeta,
                     .fixed_ns = slow_ns / slow,
                     .slow_ns = slow_ns,
                     .event_ns = event_ns,
                     .age_ns = age_ns(backlog),
                     .shortest_ns = std::max(shortest_ns, hold_.shortest_ns(latency_ns)),
                     .longest_ns = max_ns,
                     .is_new = packages_ < 4,
                     .prefer = config_.prefer})
          .best();
  return take(backlog, latency_ns, plan.length_ns, std::floor(plan.work_ns / event_ns),
              std::floor(work.up_to(plan.stay_ns) / event_ns));
}

// Drops what gets older than the bound within this length, and takes the oldest of the rest, but
// for so many that stay, thinned to a size. No more than ends in time however wrong the line of the
// cost is: of whole packages always, of others, which the clock ends, as long as the first guess is
// all there is.
Decision DeadlineLaw::take(const Backlog& backlog, double latency_ns, double length_ns, double size,
                           double stay) noexcept {
  const double keep_ns = latency_ns - length_ns;
  age_ns_ = age_ns(backlog);
  std::size_t stale = 0;
  if (age_ns_ > keep_ns) {
    stale = backlog.counts.before(backlog.now_ns - static_cast<std::int64_t>(keep_ns));
    if (stale >= backlog.count) return Decision::drop(backlog.count);
    age_ns_ = std::min(age_ns_, std::max(keep_ns, 0.0));
  }
  const auto left = static_cast<double>(backlog.count - stale);
  size = std::clamp(size, 1.0, left);
  const double raw = std::clamp(left - stay, size, left);
  Decision decision = Decision::take(static_cast<std::size_t>(raw), size / raw);
  decision.stale = stale;
  const double max_event_ns = cost_.max_event_ns();
  if (is_whole() || packages_ < kFirst) {
    const double room_ns = std::max(latency_ns - age_ns_, length_ns);
    const double safe = safe_size(room_ns, latency_ns, size);
    decision = safe_slice(decision, safe);
    if (size > safe && is_early()) decision = newest_of(backlog, decision, latency_ns);
  }
  decision = within(std::clamp(length_ns, 1.0, kMaxBudgetNs), decision);
  if (max_event_ns > 1.1 * cost_.beta_ns()) decision.max_event_ns = max_event_ns;
  return decision;
}

// Where the events of a package take hardly longer than what is fixed, and a package as long as
// the bound has time for all that comes in it, dropping events saves next to nothing. Then the
// reserve and the caution, which are for how much to take, would throw away what mostly ends in
// time. So every event is taken that a package which nothing disturbs finishes within the bound
// itself. A slope that its own error exceeds does not count; the package stays so small that it
// takes no longer than the bound if that was wrong.
std::optional<Decision> DeadlineLaw::try_all(const Backlog& backlog, const WorkByAge& work,
                                             double latency_ns) noexcept {
  if (!is_whole() || packages_ < kTells) return std::nullopt;
  const double recent_ns = kRecent * latency_ns;
  const double certainty = cost_.certainty();
  const double bound_ns = reachable_ns();
  const double alpha_ns = cost_.undisturbed_alpha_ns();
  const double spare = std::max(1.0 - alpha_ns / bound_ns, 0.0);
  if (certainty * work.up_to(recent_ns) > spare * recent_ns) return std::nullopt;
  const double cheap_ns = kCheap * alpha_ns;
  if (certainty * work.up_to(bound_ns - alpha_ns - cheap_ns) > cheap_ns) return std::nullopt;
  const double event_ns = certainty * cost_.beta_ns();
  const double most = cost_.trial_size(bound_ns);
  const auto younger = [&](double age_ns) {
    const std::int64_t since_ns = backlog.now_ns - std::llround(std::max(age_ns, 0.0));
    return static_cast<double>(backlog.count - backlog.counts.about_before(since_ns));
  };
  double keep_ns = age_ns(backlog);
  double size = 0.0;
  for (int i = 0; i < kRounds; ++i) {
    size = std::min(younger(keep_ns), most);
    keep_ns = bound_ns - (alpha_ns + event_ns * size);
  }
  if (size < 1.0 || keep_ns <= 0.0 || event_ns * size > cheap_ns) return std::nullopt;
  age_ns_ = std::min(age_ns(backlog), keep_ns);
  const auto stale = backlog.counts.before(backlog.now_ns - static_cast<std::int64_t>(keep_ns));
  if (stale >= backlog.count) return Decision::drop(backlog.count);
  const auto left = static_cast<double>(backlog.count - stale);
  Decision decision = Decision::take(static_cast<std::size_t>(std::min(left, most)));
  decision.stale = stale;
  return within(std::max(bound_ns - age_ns_, 1.0), decision);
}

// In place of a first slice that cannot hold what comes while it is processed: the newest events,
// where few packages fit into a bound while sizes grow. The others would be lost later, and the
// newest leave the most room to grow.
Decision DeadlineLaw::newest_of(const Backlog& backlog, const Decision& slice,
                                double latency_ns) noexcept {
  if (kGrowth * cost_.recent_cost_ns() < latency_ns) return slice;
  const double young_ns = kNewest * cost_.recent_cost_ns();
  const double safe = safe_size(latency_ns - young_ns, latency_ns, kAll);
  const auto older = backlog.counts.before(backlog.now_ns - std::llround(young_ns));
  if (older <= slice.stale || static_cast<double>(backlog.count - older) < safe) return slice;
  age_ns_ = young_ns;
  Decision newest = Decision::take(static_cast<std::size_t>(safe));
  newest.stale = older;
  return newest;
}

// The user's bound, or 2.5 alpha, undisturbed, if larger: no shorter bound is reachable. alpha is
// ignored while it is a guess.
double DeadlineLaw::reachable_ns() const noexcept {
  const auto bound_ns = static_cast<double>(latency_bound_ns_.load());
  return is_early() ? bound_ns : std::max(bound_ns, kReach * cost_.undisturbed_alpha_ns());
}

// The reachable bound less a margin for noise and one for outages.
double DeadlineLaw::planned_ns() const noexcept {
  const double latency_ns = reachable_ns() * (1.0 - 0.05 * std::max(0.0, cost_.sigma() - 0.05));
  return latency_ns - reserve_.ns(latency_ns, cost_.alpha_ns());
}

void DeadlineLaw::observe(const Outcome& outcome) noexcept {
  const bool was_early = is_early();
  BoundedScheme::observe(outcome);
  if (outcome.size == 0 || was_early) return;  // the first guess may be to blame
  reserve_.observe(age_ns_ + static_cast<double>(outcome.processing_ns),
                   static_cast<double>(outcome.span_ns), reachable_ns());
}

bool DeadlineLaw::is_early() const noexcept { return asap::is_early(packages_); }

double DeadlineLaw::caution() const noexcept {
  return is_whole() ? 1.0 + kCaution * cost_.sigma() : 1.0;
}

// Caution with events costs little, as they wait for the next package. Caution with the fixed cost
// costs events where two packages hardly fit into a bound.
double DeadlineLaw::fixed_caution(double latency_ns) const noexcept {
  if (!is_whole()) return 1.0;
  return 1.0 + cost_.sigma() * std::min(kCaution, kSlack * latency_ns / cost_.alpha_ns());
}

double DeadlineLaw::safe_size(double room_ns, double latency_ns, double enough) const noexcept {
  return cost_.safe_size(room_ns, fixed_caution(latency_ns), caution(), enough);
}

}  // namespace

Deadline::Deadline(Config config) : LearningScheme(std::make_unique<DeadlineLaw>(config)) {}

std::size_t Deadline::memory_bytes() noexcept { return sizeof(DeadlineLaw); }

double Deadline::alpha_ns() const noexcept {
  return static_cast<const DeadlineLaw&>(*law_).alpha_ns();
}
double Deadline::beta_ns() const noexcept {
  return static_cast<const DeadlineLaw&>(*law_).beta_ns();
}

}  // namespace asap::inline v0_1
