#include "packager/anytime_plan.hpp"

#include <algorithm>

namespace asap::inline v0_1 {
namespace {

constexpr std::size_t kMinStratum = 64;   // raw events: reading the clock must cost nothing
constexpr double kMinStratumNs = 2000;    // likewise, where events are dear
constexpr double kPriorShare = 1.0 / 32;  // of the planned events: weight of the expected cost
constexpr double kCoverage = 0.02;        // of the planned events: no stratum stays empty
constexpr double kDear = 3.0;             // times the cost so far: algorithms vary
constexpr std::int64_t kLongestNs = 1'000'000'000'000'000;

// Returns the number of strata: kMinStratum events each, or more strata if one of that size would
// take longer than its share of the budget.
std::size_t strata(const Decision& decision) noexcept {
  constexpr auto kMax = static_cast<double>(AnytimePlan::kMaxStrata);
  const auto raw = static_cast<double>(decision.raw);
  const double work_ns = decision.gamma * raw * std::max(decision.event_ns, decision.max_event_ns);
  const auto budget_ns = static_cast<double>(decision.budget_ns);
  const double share_ns = std::max(budget_ns / kMax, kMinStratumNs);
  const double by_time = (work_ns < budget_ns ? work_ns : budget_ns) / share_ns;
  const auto by_count = static_cast<double>(decision.raw / kMinStratum);
  return static_cast<std::size_t>(
      std::max(1.0, std::min({kMax, raw, std::max(by_count, by_time)})));
}

// In the expected cost of an event, which may be more.
double trust(const Decision& decision) noexcept {
  const bool is_doubted = decision.event_ns < decision.max_event_ns;
  return is_doubted ? decision.event_ns / decision.max_event_ns : 1.0;
}

// Raw events of the first stratum that come before the rest of it: so few that they keep to its
// share of the time even if an event costs the most that it may.
std::size_t probe(const Decision& decision, std::size_t strata) noexcept {
  if (trust(decision) == 1.0 || strata == 1 || decision.budget_ns <= 0) return 0;
  const double share_ns = static_cast<double>(decision.budget_ns) / static_cast<double>(strata);
  const double safe = std::max(1.0, share_ns / decision.max_event_ns);
  const auto raw = static_cast<double>(decision.raw / strata);
  return safe < raw ? static_cast<std::size_t>(safe) : 0;
}

// Clamps any double to a valid duration.
std::int64_t bounded_ns(double ns) noexcept {
  return ns > 0 ? static_cast<std::int64_t>(std::min(ns, static_cast<double>(kLongestNs))) : 0;
}

}  // namespace

AnytimePlan::AnytimePlan(const Decision& decision, std::int64_t start_ns,
                         std::int64_t grace_ns) noexcept
    : raw_(decision.raw),
      strata_(strata(decision)),
      probe_(probe(decision, strata_)),
      planned_(decision.gamma * static_cast<double>(raw_)),
      start_ns_(start_ns),
      end_ns_(start_ns + std::clamp<std::int64_t>(decision.budget_ns, 0, kLongestNs)),
      grace_ns_(grace_ns),
      fixed_end_ns_(start_ns + bounded_ns(decision.fixed_ns)),
      weight_(std::max(1.0, kPriorShare * trust(decision) * planned_)),
      spent_ns_(weight_ * std::max(0.0, decision.event_ns)) {}

std::size_t AnytimePlan::longest_stratum(std::size_t raw) noexcept {
  return raw / kMaxStrata + 2 * kMinStratum;
}

AnytimePlan::Stratum AnytimePlan::next(std::int64_t now_ns, std::size_t size) noexcept {
  if (parts_ > 0) {
    const auto stratum_ns = static_cast<double>(now_ns - stratum_start_ns_);
    if (parts_ > 1) judge(stratum_ns, static_cast<double>(size));  // the fixed cost is in the first
    if (parts_ == 1 && strata_ > 1) first_ = {size, now_ns - start_ns_};
    spent_ns_ += parts_ == 1 ? first_events_ns(stratum_ns, static_cast<double>(size)) : stratum_ns;
    weight_ += static_cast<double>(size);
    if (now_ns > end_ns_ + grace_ns_) return {};
  }
  if (done_ == strata_) return {};
  const bool is_probe = probe_ > 0 && parts_ == 0;
  const Stratum stratum{.begin = done_ == 0 && !is_probe ? probe_ : raw_ * done_ / strata_,
                        .end = is_probe ? probe_ : raw_ * (done_ + 1) / strata_,
                        .gamma = gamma(now_ns),
                        .is_last = done_ + 1 == strata_};
  ++parts_;
  if (!is_probe) ++done_;
  stratum_start_ns_ = now_ns;
  return stratum;
}

// Returns the first part's time less the expected fixed cost, unless that passed before it; at
// least what its events were expected to take.
double AnytimePlan::first_events_ns(double part_ns, double size) const noexcept {
  const std::int64_t fixed_ns = fixed_end_ns_ - stratum_start_ns_;
  if (fixed_ns < stratum_start_ns_ - start_ns_) return part_ns;
  const double beyond_ns = part_ns - static_cast<double>(fixed_ns);
  return std::min(part_ns, std::max(beyond_ns, size * spent_ns_ / weight_));
}

void AnytimePlan::judge(double stratum_ns, double size) noexcept {
  if (size <= 0) return;
  const double expected_ns = size * (spent_ns_ - outage_ns_ - suspect_ns_) / weight_;
  if (stratum_ns <= kDear * expected_ns) {
    outage_ns_ += suspect_ns_;
    suspect_ns_ = 0;
    return;
  }
  const double excess_ns = stratum_ns - expected_ns;
  const bool is_first = suspect_ns_ == 0;  // two in a row are no outage, but dear events
  suspect_ns_ = is_first && excess_ns > static_cast<double>(grace_ns_) ? excess_ns : 0;
}

std::int64_t AnytimePlan::outage_ns() const noexcept {
  return static_cast<std::int64_t>(outage_ns_ + suspect_ns_);
}

double AnytimePlan::gamma(std::int64_t now_ns) const noexcept {
  const auto strata = static_cast<double>(strata_);
  auto left_ns = static_cast<double>(end_ns_ - now_ns);
  // If it takes all, the least gets through, and what that costs corrects a wrong belief.
  if (strata_ == 1) left_ns -= std::max(static_cast<double>(fixed_end_ns_ - now_ns), 0.0);
  left_ns /= strata - static_cast<double>(done_);
  const double event_ns = spent_ns_ / weight_;
  const double raw = static_cast<double>(raw_) / strata;
  const double size = event_ns * raw <= left_ns ? raw : left_ns / event_ns;
  // Without an event in the first stratum a fixed cost beyond the budget would be paid for nothing.
  const double min = std::max(kCoverage * planned_ / strata, done_ == 0 ? 1.0 : 0.0);
  return std::clamp(std::max(size, min) / raw, 0.0, 1.0);
}

}  // namespace asap::inline v0_1
