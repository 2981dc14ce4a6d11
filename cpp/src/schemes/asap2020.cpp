#include "asap/schemes/asap2020.hpp"

#include <algorithm>
#include <cmath>

#include "core/check.hpp"

namespace asap::inline v0_1 {
namespace {

constexpr double kMinGamma = 0.02;
constexpr double kGammaRecovery = 1.02;    // per package
constexpr std::int64_t kMinSpanNs = 2000;  // of a rate: timestamps have 1 us

}  // namespace

Asap2020::Asap2020(Config config) : config_(config) {
  require(config.rate_bound > 0 && std::isfinite(config.rate_bound), "rate_bound",
          config.rate_bound, "must be a positive number of events per second");
  require(config.epsilon >= 0 && config.epsilon < 1, "epsilon", config.epsilon,
          "must be at least 0 and below 1");
  require(config.min_size >= 1, "min_size", config.min_size, "must be at least 1 event");
  require(config.max_size >= config.min_size && config.max_size <= kLargestSize, "max_size",
          config.max_size, "must be at least min_size and at most 2^40 events");
  require(config.first_size >= config.min_size && config.first_size <= config.max_size,
          "first_size", config.first_size, "must lie between min_size and max_size");
  reset(Execution::whole);
}

void Asap2020::reset(Execution) noexcept {
  size_ = static_cast<double>(config_.first_size);
  gamma_ = 1.0;
}

Decision Asap2020::decide(const Backlog& backlog) noexcept {
  const auto raw = static_cast<std::size_t>(std::ceil(size_ / gamma_));
  if (backlog.count < raw && !backlog.due) return Decision::wait_for(raw);
  return Decision::take(std::min(backlog.count, raw), gamma_);
}

void Asap2020::observe(const Outcome& outcome) noexcept {
  adapt_size(outcome);
  adapt_gamma(outcome);
}

void Asap2020::adapt_size(const Outcome& outcome) noexcept {
  if (outcome.size == 0) return;
  if (outcome.span_ns > 0 && outcome.size >= 2) {
    const double target_ns = (1.0 - config_.epsilon) * static_cast<double>(outcome.span_ns);
    const double factor = static_cast<double>(outcome.processing_ns) / target_ns;
    size_ = static_cast<double>(outcome.size) * std::clamp(factor, 0.5, 2.0);
  } else {
    size_ = 2.0 * size_;
  }
  size_ = std::clamp(std::floor(size_), static_cast<double>(config_.min_size),
                     static_cast<double>(config_.max_size));
}

void Asap2020::adapt_gamma(const Outcome& outcome) noexcept {
  const auto span_ns = static_cast<double>(std::max(outcome.span_ns, kMinSpanNs));
  const double rate = static_cast<double>(outcome.size) / (span_ns * 1e-9);
  gamma_ = rate > config_.rate_bound ? std::max(kMinGamma, gamma_ * config_.rate_bound / rate)
                                     : std::min(1.0, kGammaRecovery * gamma_);
}

}  // namespace asap::inline v0_1
