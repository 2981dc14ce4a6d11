#include "asap/schemes/dead_beat.hpp"

#include <algorithm>
#include <cmath>

#include "core/check.hpp"
#include "schemes/bounded_scheme.hpp"
#include "schemes/calibration.hpp"

namespace asap::inline v0_1 {
namespace {

class DeadBeatLaw final : public BoundedScheme {
 public:
  explicit DeadBeatLaw(DeadBeatConfig config);

  Decision decide(const Backlog& backlog) noexcept override;
  void reset(Execution execution) noexcept override;
  std::string_view name() const noexcept override { return "dead_beat"; }
  SchemeParameters parameters() const override { return parameters_in_force(config_); }

 private:
  double length_ns(std::size_t waiting) noexcept;
  double size(double budget_ns, double waiting) const noexcept;
  double caution() const noexcept;  // zeta

  const DeadBeatConfig config_;
  bool is_overloaded_;  // the knee is in force
  int calm_;            // decisions in a row with little to do
};

DeadBeatLaw::DeadBeatLaw(DeadBeatConfig config) : BoundedScheme(config), config_(config) {
  require(config.knee == 0 || (config.knee >= 1 && config.knee <= 1e6), "knee", config.knee,
          "must be 0 (off) or between 1 and 1e6");
  reset(Execution::whole);
}

void DeadBeatLaw::reset(Execution execution) noexcept {
  BoundedScheme::reset(execution);
  is_overloaded_ = false;
  calm_ = 0;
}

Decision DeadBeatLaw::decide(const Backlog& backlog) noexcept {
  const auto latency_ns = static_cast<double>(latency_bound_ns_.load());
  if (const auto wait = hold_.wait(backlog, cost_, caution(), latency_ns)) return *wait;

  const double length_ns = this->length_ns(backlog.count);
  double budget_ns = length_ns / caution();
  const double room_ns = (latency_ns - static_cast<double>(backlog.age_ns())) / caution();
  std::size_t stale = 0;
  if (room_ns < budget_ns / 2) {
    stale = backlog.counts.before(backlog.now_ns - std::llround(length_ns));
    if (stale >= backlog.count) return Decision::drop(backlog.count);
  } else {
    budget_ns = std::min(budget_ns, room_ns);
  }

  age_ns_ = static_cast<double>(backlog.age_ns());
  if (stale > 0) age_ns_ = std::min(age_ns_, length_ns);
  const bool is_single = probe_.is_due(packages_, cost_.alpha_ns(), latency_ns);
  const std::size_t raw = is_single ? 1 : backlog.count - stale;
  const auto waiting = static_cast<double>(raw);
  Decision decision = Decision::take(raw, size(budget_ns, waiting) / waiting);
  decision.stale = stale;
  if (is_whole()) {
    return safe_slice(decision, cost_.safe_size(budget_ns, 1.0, 1.0));
  }
  // As much as size() grants.
  return within(std::max({budget_ns, 1.25 * cost_.alpha_ns(), 1.0}), decision);
}

double DeadBeatLaw::length_ns(std::size_t waiting) noexcept {
  const double work_ns = caution() * cost_.predict_ns(static_cast<double>(waiting));
  const auto latency_ns = static_cast<double>(latency_bound_ns_.load());
  const double cap_ns = latency_ns / 2;
  if (config_.knee == 0) return cap_ns;
  // Never shorter than the wait before it: else what has come meanwhile would look like overload
  // for ever, and be thinned by a processor that is idle.
  const double knee_ns =
      std::max({config_.knee * cost_.alpha_ns(), cap_ns / 5, hold_.longest_ns(cost_, latency_ns)});
  const double length_ns = is_overloaded_ ? std::min(cap_ns, knee_ns) : cap_ns;
  if (!is_overloaded_) {
    is_overloaded_ = work_ns > cap_ns;  // from the next package on
    calm_ = 0;
  } else {
    const bool is_little = waiting == 1 || work_ns <= 0.9 * knee_ns;
    calm_ = is_little ? calm_ + 1 : 0;
    is_overloaded_ = calm_ < 4;
  }
  return length_ns;
}

double DeadBeatLaw::size(double budget_ns, double waiting) const noexcept {
  const double alpha_ns = cost_.alpha_ns();
  double size = std::max(budget_ns - alpha_ns, alpha_ns / 4) / cost_.beta_ns();
  return std::min(waiting, std::max(size, 1.0));
}

double DeadBeatLaw::caution() const noexcept { return is_whole() ? 1.0 + cost_.sigma() : 1.0; }

}  // namespace

DeadBeat::DeadBeat(Config config) : LearningScheme(std::make_unique<DeadBeatLaw>(config)) {}

double DeadBeat::alpha_ns() const noexcept {
  return static_cast<const DeadBeatLaw&>(*law_).alpha_ns();
}
double DeadBeat::beta_ns() const noexcept {
  return static_cast<const DeadBeatLaw&>(*law_).beta_ns();
}

}  // namespace asap::inline v0_1
