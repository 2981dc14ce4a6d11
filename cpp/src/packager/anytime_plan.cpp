#include "asap/packager/anytime_plan.hpp"

#include <algorithm>
#include <cmath>

namespace asap {
namespace {

constexpr std::size_t kMostStrata = 16;
constexpr std::size_t kLeastStratum = 64;  // raw events: reading the clock must cost nothing
constexpr double kPriorShare = 1.0 / 32;   // of the planned events: weight of the expected cost
constexpr double kCoverage = 0.02;         // of the planned events: no stratum stays empty
constexpr double kSpread = 2.0;            // standard deviations
constexpr std::int64_t kLongestNs = 1'000'000'000'000'000;

}  // namespace

AnytimePlan::AnytimePlan(const Decision& decision, std::int64_t start_ns,
                         std::int64_t grace_ns) noexcept
    : raw_(decision.raw),
      strata_(std::clamp<std::size_t>(raw_ / kLeastStratum, 1, kMostStrata)),
      planned_(decision.keep * static_cast<double>(raw_)),
      end_ns_(start_ns + std::clamp<std::int64_t>(decision.budget_ns, 0, kLongestNs)),
      grace_ns_(grace_ns),
      weight_(std::max(1.0, kPriorShare * planned_)),
      spent_ns_(weight_ * std::max(0.0, decision.event_ns)) {}

AnytimePlan::Stratum AnytimePlan::next(std::int64_t now_ns, std::size_t size) noexcept {
  if (done_ > 0) {
    spent_ns_ += static_cast<double>(now_ns - stratum_start_ns_);
    weight_ += static_cast<double>(size);
    if (now_ns > end_ns_ + grace_ns_) return {};
  }
  if (done_ == strata_) return {};
  const Stratum stratum{
      .begin = raw_ * done_ / strata_, .end = raw_ * (done_ + 1) / strata_, .keep = keep(now_ns)};
  ++done_;
  stratum_start_ns_ = now_ns;
  return stratum;
}

double AnytimePlan::keep(std::int64_t now_ns) const noexcept {
  const auto strata = static_cast<double>(strata_);
  const double left_ns =
      static_cast<double>(end_ns_ - now_ns) / (strata - static_cast<double>(done_));
  const double event_ns = spent_ns_ / weight_;
  const double raw = static_cast<double>(raw_) / strata;
  double size = event_ns * raw <= left_ns ? raw : left_ns / event_ns;
  if (done_ + 1 == strata_) size -= excess(size, raw, event_ns);
  // Without an event in the first stratum a fixed cost beyond the budget would be paid for nothing.
  const double least = std::max(kCoverage * planned_ / strata, done_ == 0 ? 1.0 : 0.0);
  return std::clamp(std::max(size, least) / raw, 0.0, 1.0);
}

// The last stratum keeps a random number of events and nothing follows that could make up for it:
// by how much it may exceed its plan, beyond the grace.
double AnytimePlan::excess(double size, double raw, double event_ns) const noexcept {
  if (!(size > 0.0 && size < raw)) return 0.0;
  const double spread = kSpread * std::sqrt(size * (1.0 - size / raw));
  return std::max(0.0, spread - static_cast<double>(grace_ns_) / event_ns);
}

}  // namespace asap
