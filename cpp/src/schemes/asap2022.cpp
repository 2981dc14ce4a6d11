#include "asap/schemes/asap2022.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "core/check.hpp"
#include "schemes/driver_containers.hpp"

namespace asap::inline v0_1 {
namespace {

constexpr double kFirstRate = 5e5;
constexpr double kLeak = 0.99;
constexpr double kMinWindowNs = 1000;
constexpr double kMeanOf = 16;          // containers
constexpr double kMinMeanGamma = 0.02;  // so that a take has an end

double law(double kappa, double processing_ms) noexcept {
  return std::atan(kappa * std::log(processing_ms));
}

double in_ms(std::chrono::nanoseconds time) noexcept {
  return static_cast<double>(time.count()) / 1e6;
}

class Asap2022Law final : public Scheme {
 public:
  explicit Asap2022Law(Asap2022Config config);

  Decision decide(const Backlog& backlog) noexcept override;
  void observe(const Outcome& outcome) noexcept override;
  void reset(Execution execution) noexcept override;
  std::string_view name() const noexcept override { return "asap2022"; }
  SchemeParameters parameters() const override { return parameters_of(config_); }

 private:
  static constexpr std::size_t kWindow = 500;  // containers

  void pass_containers(std::int64_t oldest_ns) noexcept;
  void adapt_gamma(std::int64_t container_ns) noexcept;
  void adapt_size(double processing_ms) noexcept;
  double kept_of(double raw) const noexcept;
  std::size_t raw_for_size() const noexcept;

  const Asap2022Config config_;
  double scale_;  // S

  double size_;  // a whole number
  double top_gamma_;
  double gamma_;       // of the open container
  double mean_gamma_;  // of the last containers
  double r_max_;       // containers per second
  double r_min_;

  DriverContainers containers_;
  std::array<std::int64_t, kWindow> container_ns_{};
  std::uint64_t container_count_ = 0;

  // The take that is not yet counted into containers.
  std::size_t taken_ = 0;
  std::int64_t asked_oldest_ns_ = 0;
  std::int64_t asked_now_ns_ = 0;
};

Asap2022Law::Asap2022Law(Asap2022Config config) : config_(config) {
  using namespace std::chrono_literals;
  require_time(config.min_processing >= 1ns && config.min_processing <= 1'000'000s,
               "min_processing", config.min_processing, TimeUnit::ms,
               "must be between 1e-6 and 1e9 ms");
  require_time(config.max_processing > config.min_processing && config.max_processing <= 1'000'000s,
               "max_processing", config.max_processing, TimeUnit::ms,
               "must be above the minimum and at most 1e9 ms");
  require(config.min_size >= 1, "min_size", config.min_size, "must be at least 1 event");
  require(config.max_size >= config.min_size && config.max_size <= kLargestSize, "max_size",
          config.max_size, "must be at least min_size and at most 2^40 events");
  require(config.min_gamma >= 0 && config.min_gamma <= 1, "min_gamma", config.min_gamma,
          "must be between 0 and 1");
  require(config.max_gamma > 0 && config.max_gamma >= config.min_gamma && config.max_gamma <= 1,
          "max_gamma", config.max_gamma, "must be above 0, at least min_gamma and at most 1");
  require(config.first_size >= 1 && config.first_size <= kLargestSize, "first_size",
          config.first_size, "must be between 1 and 2^40 events");
  const double rise = law(config.kappa, in_ms(config.max_processing)) -
                      law(config.kappa, in_ms(config.min_processing));
  require(rise > 1e-9 && std::isfinite(config.kappa), "kappa", config.kappa,
          "must be positive, and such that the size changes between the processing times; 1 will");
  scale_ = static_cast<double>(config.max_size - config.min_size) / rise;
  reset(Execution::whole);
}

void Asap2022Law::reset(Execution) noexcept {
  size_ = static_cast<double>(config_.first_size);
  top_gamma_ = gamma_ = mean_gamma_ = config_.max_gamma;
  r_max_ = r_min_ = kFirstRate;
  containers_ = {};
  container_count_ = 0;
  taken_ = 0;
}

Decision Asap2022Law::decide(const Backlog& backlog) noexcept {
  pass_containers(backlog.oldest_ns);
  asked_oldest_ns_ = backlog.oldest_ns;
  asked_now_ns_ = backlog.now_ns;
  const std::size_t wanted = raw_for_size();
  if (backlog.count < wanted && !backlog.due) return Decision::wait_for(wanted);
  const std::size_t raw = std::min(backlog.count, wanted);
  return Decision::take(raw, kept_of(static_cast<double>(raw)) / static_cast<double>(raw));
}

void Asap2022Law::observe(const Outcome& outcome) noexcept {
  taken_ += outcome.raw;
  if (outcome.size > 0) adapt_size(static_cast<double>(outcome.processing_ns) * 1e-6);
}

// A push node gives each container its own gamma, however many make up a package. Here a take has
// one: what the open container's gamma and, beyond it, the mean gamma will keep.
double Asap2022Law::kept_of(double raw) const noexcept {
  const double open = std::min(raw, static_cast<double>(containers_.left()));
  return open * gamma_ + (raw - open) * mean_gamma_;
}

std::size_t Asap2022Law::raw_for_size() const noexcept {
  const auto open = static_cast<double>(containers_.left());
  const double beyond = size_ - open * gamma_;
  const double raw =
      beyond <= 0 ? size_ / gamma_ : open + beyond / std::max(mean_gamma_, kMinMeanGamma);
  return static_cast<std::size_t>(std::ceil(raw));
}

// What was taken lies between the oldest event of then and that of now, and had arrived.
void Asap2022Law::pass_containers(std::int64_t oldest_ns) noexcept {
  if (taken_ == 0) return;
  const std::int64_t until_ns =
      std::clamp(oldest_ns, asked_oldest_ns_, std::max(asked_oldest_ns_, asked_now_ns_));
  containers_.pass(taken_, asked_oldest_ns_, until_ns,
                   [this](std::int64_t time_ns) { adapt_gamma(time_ns); });
  taken_ = 0;
}

void Asap2022Law::adapt_gamma(std::int64_t container_ns) noexcept {
  container_ns_[container_count_ % kWindow] = container_ns;
  ++container_count_;
  if (container_count_ <= kWindow) return;
  const std::int64_t oldest_ns = container_ns_[container_count_ % kWindow];
  const double window_ns = static_cast<double>(container_ns) - static_cast<double>(oldest_ns);
  const double r = static_cast<double>(kWindow) * 1e9 / std::max(window_ns, kMinWindowNs);
  r_max_ = r > r_max_ ? r : kLeak * r_max_;
  r_min_ = r < r_min_ ? r : r_min_ / kLeak;
  const double share = r_max_ == r_min_ ? 0.0 : (r - r_min_) / (r_max_ - r_min_);
  gamma_ = std::clamp(top_gamma_ - share * (top_gamma_ - config_.min_gamma), 0.0, 1.0);
  mean_gamma_ += (gamma_ - mean_gamma_) / kMeanOf;
}

void Asap2022Law::adapt_size(double processing_ms) noexcept {
  const double shortest = in_ms(config_.min_processing);
  const double longest = in_ms(config_.max_processing);
  const auto largest = static_cast<double>(config_.max_size);
  const double h = std::clamp(processing_ms, shortest, longest);
  const double size =
      scale_ * law(config_.kappa, h) + largest - scale_ * law(config_.kappa, longest);
  // Math libraries differ in the last bit; a run must not.
  size_ = std::clamp(std::nearbyint(size), static_cast<double>(config_.min_size), largest);
  top_gamma_ = config_.max_gamma -
               (h - shortest) / (longest - shortest) * (config_.max_gamma - config_.min_gamma);
}

}  // namespace

Asap2022::Asap2022(Config config) : LearningScheme(std::make_unique<Asap2022Law>(config)) {}

}  // namespace asap::inline v0_1
