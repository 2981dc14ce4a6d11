#include "asap/runner/simulator.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/check.hpp"
#include "core/random.hpp"

namespace asap::inline v0_1 {
namespace {

constexpr double kEndOfTimeNs = 9.2e18;  // absurd costs end here

}  // namespace

LinearCost::LinearCost(LinearCostConfig config) : config_(std::move(config)) {
  require(config_.alpha_us >= 0 && config_.alpha_us <= 1e9, "alpha_us", config_.alpha_us,
          "must be between 0 and 1e9 us");
  require(config_.beta_ns >= 0 && config_.beta_ns <= 1e9, "beta_ns", config_.beta_ns,
          "must be between 0 and 1e9 ns");
  require(config_.noise >= 0 && config_.noise <= 5, "noise", config_.noise,
          "must be between 0 and 5");
  for (const double factor : config_.drift) {
    require(factor >= 0 && factor <= 1e6, "drift", factor, "give factors between 0 and 1e6");
  }
  std::int64_t free_ns = std::numeric_limits<std::int64_t>::min();
  for (const Outage& outage : config_.outages) {
    require(outage.begin_ns >= free_ns, "outages", outage.begin_ns,
            "give them in order, each beginning after the one before has ended, ns");
    require(outage.end_ns > outage.begin_ns, "outages", outage.end_ns,
            "an outage ends after it has begun, ns");
    require(outage.end_ns <= static_cast<std::int64_t>(kEndOfTimeNs), "outages", outage.end_ns,
            "an outage ends within 9.2e18 ns of run time");
    free_ns = outage.end_ns;
  }
}

PackageCost LinearCost::package(std::uint64_t index, std::int64_t start_ns) const noexcept {
  const double factor = config_.noise > 0 ? noise_factor(index) : 1.0;
  return {.fixed_ns = factor * config_.alpha_us * 1e3, .event_ns = factor * event_ns(start_ns)};
}

std::int64_t LinearCost::done_ns(std::int64_t begin_ns, double work_ns) const noexcept {
  const double longest_ns = kEndOfTimeNs - static_cast<double>(begin_ns);
  std::int64_t left_ns = std::max<std::int64_t>(std::llround(std::min(work_ns, longest_ns)), 1);
  const auto end_ns = static_cast<std::int64_t>(kEndOfTimeNs);
  if (config_.outages.empty()) return begin_ns + std::min(left_ns, end_ns - begin_ns);
  std::int64_t now_ns = begin_ns;
  for (auto outage = outage_after(now_ns); outage != config_.outages.end(); ++outage) {
    const std::int64_t until_ns = std::max(outage->begin_ns, now_ns);
    if (left_ns <= until_ns - now_ns) break;
    left_ns -= until_ns - now_ns;
    now_ns = outage->end_ns;
  }
  return now_ns + std::min(left_ns, end_ns - now_ns);
}

std::int64_t LinearCost::start_ns(std::int64_t now_ns) const noexcept {
  if (config_.outages.empty()) return now_ns;
  auto outage = outage_after(now_ns);
  for (; outage != config_.outages.end() && outage->begin_ns <= now_ns; ++outage) {
    now_ns = outage->end_ns;  // the next one may begin there
  }
  return now_ns;
}

double LinearCost::event_ns(std::int64_t now_ns) const noexcept {
  if (config_.drift.empty()) return config_.beta_ns;
  const auto last = static_cast<std::int64_t>(config_.drift.size()) - 1;
  const std::int64_t step = std::clamp<std::int64_t>(now_ns / kDriftStepNs, 0, last);
  return config_.beta_ns * config_.drift[static_cast<std::size_t>(step)];
}

std::vector<Outage>::const_iterator LinearCost::outage_after(std::int64_t time_ns) const noexcept {
  return std::upper_bound(
      config_.outages.begin(), config_.outages.end(), time_ns,
      [](std::int64_t time, const Outage& outage) { return time < outage.end_ns; });
}

double LinearCost::noise_factor(std::uint64_t index) const noexcept {
  const CounterRandom random(config_.seed);
  // Box-Muller.
  const double u = 1.0 - random.uniform(2 * index);  // (0, 1]
  const double v = random.uniform(2 * index + 1);
  const double normal = std::sqrt(-2.0 * std::log(u)) * std::cos(2.0 * std::numbers::pi * v);
  const double factor = std::exp(config_.noise * normal - 0.5 * config_.noise * config_.noise);
  // Math libraries differ in the last bit; a run must not.
  return std::nearbyint(factor * 0x1.0p24) * 0x1.0p-24;
}

}  // namespace asap::inline v0_1
