#include "oracle/oracle.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/check.hpp"

namespace asap::inline v0_1 {
namespace {

constexpr double kFreeNs = 1e-3;  // an event that costs less counts as free: sums stay finite

}  // namespace

Oracle::Oracle(LinearCost cost, double latency_us, Execution execution) : cost_(std::move(cost)) {
  require(latency_us >= 10 && latency_us <= 1e10, "latency_us", latency_us,
          "must be between 10 and 1e10 us");
  latency_ns_ = std::llround(latency_us * 1e3);
  const LinearCostConfig& config = cost_.config();
  share_ = std::max(1.0 - config.alpha_us / latency_us, 0.0);
  const bool uses_luck = execution == Execution::anytime;
  noise_factor_ = uses_luck ? std::exp(-config.noise * config.noise) : 1.0;
}

void Oracle::feed(EventSpan events) noexcept {
  for (const Event& event : events) {
    if (!started_) axis_ = TimeAxis(event.t, 1.0);
    const std::int64_t time_ns = axis_.to_ns(event.t);
    if (!started_ || time_ns > now_ns_) arrive(time_ns);
    started_ = true;
    const double admitted = std::clamp(room_ - queue_, 0.0, 1.0);
    queue_ += admitted;
    bound_ += admitted;
  }
}

void Oracle::arrive(std::int64_t time_ns) noexcept {
  const Service served = served_by(now_, time_ns);
  const Service by_deadline = served_by(deadline_, time_ns + latency_ns_);
  const bool was_free = served.free_ns > served_.free_ns;
  const bool will_be_free = by_deadline.free_ns > served.free_ns;
  queue_ = was_free ? 0.0 : std::max(queue_ - (served.events - served_.events), 0.0);
  room_ =
      will_be_free ? std::numeric_limits<double>::infinity() : by_deadline.events - served.events;
  served_ = served;
  now_ns_ = time_ns;
}

Oracle::Service Oracle::served_by(Cursor& cursor, std::int64_t time_ns) const noexcept {
  while (time_ns >= cursor.end_ns) enter_next_stretch(cursor);
  return cursor.at(time_ns);
}

void Oracle::enter_next_stretch(Cursor& cursor) const noexcept {
  cursor.before = cursor.at(cursor.end_ns);
  cursor.begin_ns = cursor.end_ns;
  cursor.end_ns = kNever;
  cursor.events_per_ns = 0.0;
  cursor.is_free = false;

  const LinearCostConfig& config = cost_.config();
  while (cursor.outage < config.outages.size() &&
         config.outages[cursor.outage].end_ns <= cursor.begin_ns) {
    ++cursor.outage;
  }
  if (cursor.outage < config.outages.size()) {
    const Outage& outage = config.outages[cursor.outage];
    const bool is_out = outage.begin_ns <= cursor.begin_ns;
    cursor.end_ns = is_out ? outage.end_ns : outage.begin_ns;
    if (is_out) return;
  }
  const std::int64_t step = cursor.begin_ns / LinearCost::kDriftStepNs;
  if (step + 1 < static_cast<std::int64_t>(config.drift.size())) {
    cursor.end_ns = std::min(cursor.end_ns, (step + 1) * LinearCost::kDriftStepNs);
  }
  const double event_ns = cost_.event_ns(cursor.begin_ns) * noise_factor_;
  if (event_ns < kFreeNs) {
    cursor.is_free = std::round(config.alpha_us * 1e3) <= static_cast<double>(latency_ns_);
  } else {
    cursor.events_per_ns = share_ / event_ns;
  }
}

Oracle::Service Oracle::Cursor::at(std::int64_t time_ns) const noexcept {
  const std::int64_t elapsed_ns = time_ns - begin_ns;
  return {.events = before.events + events_per_ns * static_cast<double>(elapsed_ns),
          .free_ns = before.free_ns + (is_free ? elapsed_ns : 0)};
}

}  // namespace asap::inline v0_1
