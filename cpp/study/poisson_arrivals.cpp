#include "study/poisson_arrivals.hpp"

#include <cmath>

#include "core/check.hpp"
#include "synthetic/scene_checks.hpp"

namespace asap {
namespace {

constexpr std::size_t kBlock = 4096;
constexpr double kMemory = 0.90483741803595957;  // exp(-0.1): 1 ms in steps of 0.1 ms

const PoissonArrivalsConfig& checked(const PoissonArrivalsConfig& config) {
  synthetic::require_view_and_time(config.width, config.height, config.duration.count(),
                                   config.start.count());
  require(config.noise >= 0.0 && config.noise <= 1.0, "noise", config.noise, "give 0 to 1");
  return config;
}

}  // namespace

PoissonArrivals::PoissonArrivals(const PoissonArrivalsConfig& config)
    : config_(checked(config)),
      steps_(CounterRandom(config.seed)(0)),
      flicker_(CounterRandom(config.seed)(1)),
      step_(0),
      block_(kBlock) {}

void PoissonArrivals::feed(std::span<const double> rates_hz) {
  for (const double rate_hz : rates_hz) {
    require(rate_hz >= 0.0 && rate_hz <= kMaxRate_hz, "rates_hz", rate_hz,
            "give 0 to 2e9 events per second");
  }
  rates_hz_.erase(rates_hz_.begin(), rates_hz_.begin() + static_cast<std::ptrdiff_t>(next_rate_));
  next_rate_ = 0;
  rates_hz_.insert(rates_hz_.end(), rates_hz.begin(), rates_hz.end());
}

EventSpan PoissonArrivals::next() noexcept {
  const auto width = static_cast<std::uint64_t>(config_.width);
  const auto height = static_cast<std::uint64_t>(config_.height);
  std::size_t size = 0;
  while (size < kBlock && (left_ > 0 || to_next_event())) {
    const std::size_t end = size + std::min<std::uint64_t>(left_, kBlock - size);
    left_ -= end - size;
    const std::int64_t t = config_.start.count() + elapsed_us_ - 1;
    for (; size < end; ++size) {
      const std::uint64_t bits = step_(drawn_++);
      Event& event = block_[size];
      // Field by field: the padding of the buffer stays zero.
      event.x = static_cast<std::uint16_t>(((bits & 0xffffffffU) * width) >> 32);
      event.y = static_cast<std::uint16_t>(((bits >> 33) * height) >> 31);
      event.p = static_cast<std::int16_t>(bits >> 32 & 1);
      event.t = t;
    }
  }
  return {block_.data(), size};
}

// Goes on to the next microsecond that holds events.
bool PoissonArrivals::to_next_event() noexcept {
  while (elapsed_us_ < config_.duration.count()) {
    if (elapsed_us_ % kStep_us == 0) {
      if (next_rate_ == rates_hz_.size()) return false;
      open_step(rates_hz_[next_rate_++]);
      if (pieces_ == 0) {
        elapsed_us_ += kStep_us;
        continue;
      }
    }
    ++elapsed_us_;
    for (std::uint64_t piece = 0; piece < pieces_; ++piece) {
      left_ += piece_.draw(step_.uniform(drawn_++));
    }
    if (left_ > 0) return true;
  }
  return false;
}

void PoissonArrivals::open_step(double rate_hz) noexcept {
  const auto step = static_cast<std::uint64_t>(elapsed_us_ / kStep_us);
  const double normal = synthetic::near_normal(flicker_, step);
  log_factor_ =
      step == 0 ? normal : kMemory * log_factor_ + std::sqrt(1.0 - kMemory * kMemory) * normal;
  const double exponent = config_.noise * log_factor_ - 0.5 * config_.noise * config_.noise;
  const double mean = rate_hz * synthetic::portable_exp(exponent) * 1e-6;  // mean per microsecond

  step_ = CounterRandom(steps_(step));
  drawn_ = 0;
  pieces_ = static_cast<std::uint64_t>(std::ceil(mean / synthetic::PoissonTable::kMaxMean));
  if (pieces_ > 0) piece_.set_mean(mean / static_cast<double>(pieces_));
}

}  // namespace asap
