#include "schemes/bounded_scheme.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "core/check.hpp"

namespace asap::inline v0_1 {
namespace {

constexpr double kMinAlphaNs = 200.0;
constexpr double kMinBetaNs = 0.1;
constexpr double kMinCostNs = 1.0;
constexpr double kMaxCostNs = 1e15;  // eleven days
constexpr double kMaxSize = 0x1p40;

constexpr std::uint64_t kPriorLasts = 6;  // packages
constexpr std::uint64_t kClipsFrom = 8;   // packages: before, every one is news
constexpr std::size_t kPriorBucket = 13;  // sizes from 8192
constexpr double kPriorWeight = 0.05;
constexpr double kSpread = 8.0;  // largest / smallest size
constexpr double kMinWeight = 0.25;
constexpr double kMaxWeight = 16.0;
constexpr double kQuickGain = 0.25;  // of a package that is quicker than its size is known for
constexpr double kSlowGain = 0.05;   // of a slower one
constexpr double kConfirmed = 2.0;   // packages: the first of a size may have been clipped
constexpr double kMaxScale = 3.0;
constexpr double kMaxRise = 2.0;
constexpr double kMaxFall = -0.5;
constexpr double kRefuted = 0.25;  // of the fixed cost
constexpr double kFirstSigma = 0.15;
constexpr double kMinSigma = 0.01;
constexpr double kMaxSigma = 0.4;
constexpr double kScaleGain = 0.2;
constexpr double kSigmaGain = 0.05;
constexpr double kSigmaWeight = 4.0;  // of the first guess, in packages
constexpr double kFade = 0.98;        // of a size, per package
constexpr double kApart = 3.0;        // sizes this far apart tell alpha from beta
constexpr double kMinShare = 0.02;    // of the events in the cost of a package
constexpr double kMaxGrowth = 8.0;    // of the largest size, per package ...
constexpr double kSureGrowth = 64.0;  // ... while the first guess holds

double outlier_limit(double sigma) noexcept { return 3.0 * sigma + 0.03; }

}  // namespace

CostModel::CostModel(CostModelConfig config) : config_(config) {
  require(config.first_alpha_us >= 0.001 && config.first_alpha_us <= 1e9, "first_alpha_us",
          config.first_alpha_us, "must be between 0.001 and 1e9 us");
  require(config.first_beta_ns >= 0.001 && config.first_beta_ns <= 1e9, "first_beta_ns",
          config.first_beta_ns, "must be between 0.001 and 1e9 ns");
  reset();
}

void CostModel::reset() noexcept {
  alpha_ns_ = config_.first_alpha_us * 1e3;
  beta_ns_ = config_.first_beta_ns;
  beta_error_ns_ = std::numeric_limits<double>::infinity();
  scale_ = 1.0;
  sigma_ = kFirstSigma;
  streak_ = 0;
  min_error_ = 0.0;
  count_ = 0;
  level_start_ = 0;
  smallest_ = kMaxSize;
  largest_ = 0.0;
  guess_holds_ = true;
  recent_size_ = 0.0;
  recent_cost_ns_ = 0.0;
  max_event_ns_ = std::numeric_limits<double>::infinity();
  buckets_ = {};
  asked_for_ = 0;
  for (const std::size_t octave : {std::size_t{0}, kPriorBucket}) {
    const auto size = static_cast<double>(std::size_t{1} << octave);
    bucket(size) = {kPriorWeight, size, line_ns(size), true};
  }
}

double CostModel::doubted_event_ns() const noexcept {
  return on_level() <= kPriorLasts ? std::max(beta_ns(), max_event_ns_) : beta_ns();
}

void CostModel::update(const Outcome& outcome) noexcept {
  const bool has_parts = outcome.first_size > 0 && outcome.first_size < outcome.size;
  const double gain = has_parts ? kScaleGain / 2 : kScaleGain;
  if (has_parts) learn(outcome.first_size, outcome.first_ns, {.scale = gain, .sigma = 0.0});
  learn(outcome.size, outcome.work_ns(), {.scale = gain, .sigma = kSigmaGain});
}

void CostModel::learn(std::size_t size, std::int64_t time_ns, Gains gains) noexcept {
  if (size == 0 || time_ns < 0) return;
  const double n = std::min(static_cast<double>(size), kMaxSize);
  const double measured_ns = std::clamp(static_cast<double>(time_ns), kMinCostNs, kMaxCostNs);
  watch(n, measured_ns);
  const double expected_ns = predict_ns(n);
  const double error = measured_ns / expected_ns - 1.0;
  const double noise = std::min(std::abs(error), outlier_limit(sigma_));
  if (std::abs(error) > outlier_limit(sigma_)) guess_holds_ = false;
  double cost_ns = std::clamp(expected_ns * (1.0 + clipped(error, n)), kMinCostNs, kMaxCostNs);
  // A single event, the look of a scheme that doubts, costs at least what is fixed.
  if (n == 1.0 && measured_ns < kRefuted * alpha_ns()) bucket(n) = {};
  if (bucket(n).is_new()) cost_ns = std::min(cost_ns, measured_ns);
  smallest_ = std::min(smallest_, n);
  largest_ = std::max(largest_, n);
  forget();
  remember(n, cost_ns);
  fit();
  if (on_level() >= kClipsFrom) follow(n, cost_ns, noise, gains);
  ++count_;
}

// A smaller package tells nothing about larger ones, with two exceptions: if it is cheaper per
// event, the larger one met an outage; if it is dearer as a whole by more than the noise, the cost
// has risen since.
void CostModel::watch(double size, double cost_ns) noexcept {
  recent_size_ *= kFade;
  const double dearer_ns = recent_cost_ns_ * (1.0 + outlier_limit(sigma_));
  const bool is_known =
      size < recent_size_ && cost_ns >= max_event_ns_ * size && cost_ns <= dearer_ns;
  if (is_known) return;
  recent_size_ = size;
  recent_cost_ns_ = cost_ns;
  max_event_ns_ = cost_ns / size;
}

double CostModel::clipped(double error, double size) noexcept {
  if (on_level() < kClipsFrom) return error;
  const double limit = outlier_limit(sigma_);
  if (std::abs(error) <= limit) {
    streak_ = 0;
    return error;
  }
  const int side = error > 0 ? 1 : -1;
  const bool goes_on = streak_ * side > 0;
  min_error_ = goes_on && std::abs(min_error_) < std::abs(error) ? min_error_ : error;
  streak_ = goes_on ? streak_ + side : side;
  if (std::abs(streak_) < 3) return std::clamp(error, -limit, limit);
  streak_ = 0;
  if (min_error_ <= kMaxRise && min_error_ >= kMaxFall) return std::min(error, kMaxRise);
  start_level(1.0 + min_error_, size);
  return error;
}

// What is known, times the factor, is but the first guess about an algorithm that has changed.
// (Otherwise a whole package that has become 100 times as dear is repeated twenty times. And where
// the cost falls, packages grow and the old, dear memory of small ones looks like a fixed cost for
// hundreds of packages.) A fall that the fixed cost alone explains says nothing about the rest.
void CostModel::start_level(double factor, double size) noexcept {
  const double fall_ns = (1.0 - factor) * predict_ns(size);
  const bool is_fixed_cost = fall_ns > 0.0 && fall_ns < alpha_ns() && fall_ns < min_cost_ns();
  rebase(is_fixed_cost ? scale_ : scale_ * factor);
  for (Bucket& bucket : buckets_) {
    if (is_fixed_cost) bucket.cost_ns = std::max(bucket.cost_ns - fall_ns, kMinAlphaNs);
    bucket.weight = std::min(bucket.weight, kPriorWeight);
    bucket.is_prior = true;
  }
  sigma_ = std::max(sigma_, kFirstSigma);
  level_start_ = count_;
  smallest_ = kMaxSize;
  largest_ = 0.0;
}

// The lowest cost that is remembered. No fixed cost is larger.
double CostModel::min_cost_ns() const noexcept {
  double min_ns = kMaxCostNs;
  for (const Bucket& bucket : buckets_) {
    if (bucket.weight > 0) min_ns = std::min(min_ns, scale_ * bucket.cost_ns);
  }
  return min_ns;
}

template <class Self, class Call>
void CostModel::each_asked_for(Self& self, const Call& call) noexcept {
  for (std::uint32_t left = self.asked_for_; left != 0; left &= left - 1) {
    call(self.buckets_[static_cast<std::size_t>(std::countr_zero(left))]);
  }
}

void CostModel::forget() noexcept {
  each_asked_for(*this, [this](Bucket& bucket) {
    if (bucket.weight > kMinWeight) {
      bucket.weight = std::max(kMinWeight, 0.998 * bucket.weight);
    } else if (bucket.is_prior && on_level() >= kPriorLasts && knows_better(bucket)) {
      // With weights of 1 / c^2 a prior that is far too small would rule for ever.
      bucket.weight = 0.0;
    }
  });
}

// After a change of level: whether the sizes since tell alpha from beta without this memory of
// before. About far larger ones they never do.
bool CostModel::knows_better(const Bucket& prior) const noexcept {
  return level_start_ == 0 || (largest_ >= kSpread * smallest_ && prior.size <= kSpread * largest_);
}

CostModel::Bucket& CostModel::bucket(double size) noexcept {
  const auto octave = static_cast<std::size_t>(std::bit_width(static_cast<std::size_t>(size))) - 1;
  const std::size_t i = std::min(octave, buckets_.size() - 1);
  asked_for_ |= std::uint32_t{1} << i;
  return buckets_[i];
}

void CostModel::remember(double size, double cost_ns) noexcept {
  Bucket& bucket = this->bucket(size);
  if (bucket.is_new()) {
    bucket = {1.0, size, cost_ns, false};
    return;
  }
  bucket.weight = std::min(bucket.weight + 1.0, kMaxWeight);
  const double gain = 1.0 / std::max(bucket.weight, 2.0);
  const double slope_ns = std::min(beta_ns_, bucket.cost_ns / bucket.size);
  const double moved = gain * (size - bucket.size);
  const double error_ns = cost_ns - bucket.cost_ns - slope_ns * (size - bucket.size);
  const double slower_ns = std::min(error_ns, outlier_limit(sigma_) * bucket.cost_ns);
  bucket.size += moved;
  bucket.cost_ns += slope_ns * moved;
  bucket.cost_ns += error_ns < 0 ? std::max(gain, kQuickGain) * error_ns : kSlowGain * slower_ns;
  bucket.cost_ns = std::max(bucket.cost_ns, kMinCostNs);
}

// At most a third as large as the largest recent one.
CostModel::Mean CostModel::smaller_packages() const noexcept {
  Mean small;
  each_asked_for(*this, [&, limit = recent_size() / kApart](const Bucket& bucket) {
    if (bucket.weight <= 0 || bucket.is_prior || bucket.size > limit) return;
    small.weight += bucket.weight;
    small.size += bucket.weight * bucket.size;
    small.cost_ns += bucket.weight * bucket.cost_ns;
  });
  if (small.weight > 0) {
    small.size /= small.weight;
    small.cost_ns *= scale_ / small.weight;
  }
  return small;
}

// Upper bound on beta: the slope of the line through the smaller packages and the largest recent
// one, and one standard error. What is fixed is in both of them and drops out.
double CostModel::max_beta_ns(const Mean& small) const noexcept {
  const double error_ns = sigma_ * std::sqrt(recent_cost_ns_ * recent_cost_ns_ +
                                             small.cost_ns * small.cost_ns / small.weight);
  return std::max((recent_cost_ns_ - small.cost_ns + error_ns) / (recent_size() - small.size),
                  kMinShare * max_event_ns_);
}

double CostModel::certainty() const noexcept {
  if (on_level() <= kPriorLasts) return 1.0;
  return std::clamp(beta_ns_ / beta_error_ns_ - 1.0, 0.0, 1.0);
}

// Fixed costs are not negative: n events take at most n times what an event has cost, its share of
// the fixed cost included.
double CostModel::undisturbed_event_ns() const noexcept {
  double event_ns = max_event_ns_;
  each_asked_for(*this, [&](const Bucket& bucket) {
    if (bucket.weight < kConfirmed || bucket.is_prior) return;
    event_ns = std::min(event_ns, bucket.cost_ns / bucket.size);
  });
  return event_ns;
}

double CostModel::trial_size(double room_ns) const noexcept {
  double size = 0.0;
  each_asked_for(*this, [&](const Bucket& bucket) {
    if (bucket.weight > 0 && !bucket.is_prior) size = std::max(size, bucket.size);
  });
  return 1.0 + std::floor(std::min(2.0 * size, room_ns / undisturbed_event_ns()));
}

double CostModel::safe_size(double room_ns, double fixed_caution, double event_caution,
                            double enough) const noexcept {
  // One event is added: without it a fixed cost close to the room would keep packages small.
  double size = 1.0 + std::max(1.0, std::floor(room_ns / (event_caution * max_event_ns_)));
  if (size >= enough) return size;
  // Caution is for a slope that is known. Without one, packages grow as those that nothing
  // disturbed permit, or a few slow ones would keep them small.
  const double caution = 1.0 + certainty() * (event_caution - 1.0);
  size = std::max(size, 1.0 + std::floor(room_ns / (caution * undisturbed_event_ns())));
  const double spare_ns = room_ns - fixed_caution * recent_cost_ns_;
  const Mean small = smaller_packages();
  if (small.weight > 0 && spare_ns > 0) {
    const double more = spare_ns / (event_caution * max_beta_ns(small));
    size = std::max(size, recent_size() + std::min(more, (kMaxGrowth - 1.0) * recent_size()));
  }
  const bool is_sure = guess_holds_ && count_ > 0 && count_ <= kPriorLasts;
  return std::floor(is_sure ? std::max(size, kSureGrowth * largest_) : size);
}

void CostModel::fit() noexcept {
  double s0 = 0, s1 = 0, s2 = 0, y0 = 0, y1 = 0;
  each_asked_for(*this, [&](const Bucket& bucket) {
    if (bucket.weight <= 0) return;
    const double q = bucket.weight / (bucket.cost_ns * bucket.cost_ns);
    s0 += q;
    s1 += q * bucket.size;
    s2 += q * bucket.size * bucket.size;
    y0 += q * bucket.cost_ns;
    y1 += q * bucket.size * bucket.cost_ns;
  });
  const double determinant = s0 * s2 - s1 * s1;
  if (determinant > 1e-9 * s0 * s2) {
    double alpha_ns = (y0 * s2 - y1 * s1) / determinant;
    double beta_ns = (s0 * y1 - s1 * y0) / determinant;
    if (alpha_ns < kMinAlphaNs) {
      alpha_ns = kMinAlphaNs;
      beta_ns = std::max(kMinBetaNs, (y1 - alpha_ns * s1) / s2);
    }
    if (beta_ns < kMinBetaNs) {
      beta_ns = kMinBetaNs;
      alpha_ns = std::max(kMinAlphaNs, (y0 - beta_ns * s1) / s0);
    }
    alpha_ns_ = alpha_ns;
    beta_ns_ = beta_ns;
    beta_error_ns_ = sigma_ * std::sqrt(s0 / determinant);
    return;
  }
  // One size only: it says nothing about the parts, but what they sum to. (Otherwise a
  // wrong prior stays as long as n does not change.)
  const double a = alpha_ns_;
  const double b = beta_ns_;
  const double factor = (a * y0 + b * y1) / (a * a * s0 + 2.0 * a * b * s1 + b * b * s2);
  alpha_ns_ = std::max(kMinAlphaNs, factor * a);
  beta_ns_ = std::max(kMinBetaNs, factor * b);
  beta_error_ns_ = std::numeric_limits<double>::infinity();
}

void CostModel::follow(double size, double cost_ns, double noise, Gains gains) noexcept {
  scale_ += gains.scale * (std::clamp(cost_ns / line_ns(size), 0.1, 10.0) - scale_);
  const double seen = kSigmaWeight + static_cast<double>(on_level() - kClipsFrom);
  const double gain = gains.sigma > 0 ? std::max(gains.sigma, 1.0 / seen) : 0.0;
  sigma_ = std::clamp(sigma_ + gain * (noise - sigma_), kMinSigma, kMaxSigma);
  if (scale_ > kMaxScale || scale_ < 1.0 / kMaxScale) rebase(scale_);
}

// The factor becomes part of what is remembered. (Otherwise a cost that has jumped by more
// than 10 is never reached, as the memory of the cheap packages outweighs the others for ever.)
void CostModel::rebase(double factor) noexcept {
  for (Bucket& bucket : buckets_) {
    bucket.cost_ns = std::clamp(factor * bucket.cost_ns, kMinCostNs, kMaxCostNs);
  }
  alpha_ns_ *= factor;
  beta_ns_ *= factor;
  beta_error_ns_ *= factor;
  scale_ = 1.0;
}

}  // namespace asap::inline v0_1
