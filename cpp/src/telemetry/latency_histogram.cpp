#include "asap/telemetry/latency_histogram.hpp"

#include <cmath>

#include "core/atomics.hpp"
#include "core/check.hpp"

namespace asap::inline v0_1 {

LatencyHistogram::LatencyHistogram(std::int64_t bound_ns) : bound_ns_(bound_ns), bins_(kBins, 0) {}

LatencyHistogram::LatencyHistogram(const LatencyHistogram& other) : bins_(kBins) { *this = other; }

// The other one may be written to.
LatencyHistogram& LatencyHistogram::operator=(const LatencyHistogram& other) noexcept {
  const auto copy = [](auto& to, const auto& from) { to = load_relaxed(from); };
  for (std::size_t bin = 0; bin < kBins; ++bin) copy(bins_[bin], other.bins_[bin]);
  copy(bound_ns_, other.bound_ns_);
  copy(count_, other.count_);
  copy(within_bound_, other.within_bound_);
  copy(max_ns_, other.max_ns_);
  copy(sum_low_, other.sum_low_);
  copy(sum_high_, other.sum_high_);
  return *this;
}

void LatencyHistogram::clear(std::int64_t bound_ns) noexcept {
  bound_ns_ = bound_ns;
  std::ranges::fill(bins_, 0U);
  count_ = within_bound_ = sum_low_ = sum_high_ = 0;
  max_ns_ = 0;
}

void LatencyHistogram::set_bound_ns(std::int64_t bound_ns) noexcept {
  store_relaxed(bound_ns_, bound_ns);
}

double LatencyHistogram::mean_ns() const noexcept {
  if (count_ == 0) return 0.0;
  const double sum = static_cast<double>(sum_high_) * 0x1.0p64 + static_cast<double>(sum_low_);
  return sum / static_cast<double>(count_);
}

double LatencyHistogram::quantile_ns(double q) const {
  require(q >= 0.0 && q <= 1.0, "q", q, "must be a number between 0 and 1");
  if (count_ == 0) return 0.0;
  const double wanted = std::ceil(q * static_cast<double>(count_));
  const std::uint64_t rank = std::max<std::uint64_t>(static_cast<std::uint64_t>(wanted), 1);
  if (rank >= count_) return static_cast<double>(max_ns_);
  std::uint64_t seen = 0;
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    seen += bins_[bin];
    if (seen >= rank) return std::min(middle_of(bin), static_cast<double>(max_ns_));
  }
  return static_cast<double>(max_ns_);
}

LatencyHistogram LatencyHistogram::since(const LatencyHistogram& earlier) const {
  LatencyHistogram later(bound_ns_);
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    const std::uint64_t count = bins_[bin] - earlier.bins_[bin];
    if (count == 0) continue;
    later.add(bin, count);
    later.count_ += count;
    later.max_ns_ = std::min(max_of(bin), max_ns_);
  }
  later.within_bound_ = within_bound_ - earlier.within_bound_;
  later.sum_low_ = sum_low_ - earlier.sum_low_;
  later.sum_high_ = sum_high_ - earlier.sum_high_ - (sum_low_ < earlier.sum_low_ ? 1U : 0U);
  return later;
}

LatencyHistogram::State LatencyHistogram::state() const {
  State state{.bound_ns = bound_ns_,
              .max_ns = max_ns_,
              .within_bound = within_bound_,
              .sum_low = sum_low_,
              .sum_high = sum_high_,
              .bins = {}};
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    if (bins_[bin] > 0) state.bins.emplace_back(static_cast<std::uint32_t>(bin), bins_[bin]);
  }
  return state;
}

LatencyHistogram LatencyHistogram::restored(const State& state) {
  LatencyHistogram histogram(state.bound_ns);
  histogram.max_ns_ = state.max_ns;
  histogram.within_bound_ = state.within_bound;
  histogram.sum_low_ = state.sum_low;
  histogram.sum_high_ = state.sum_high;
  for (const auto& [bin, count] : state.bins) {
    require(bin < kBins, "bin", bin, "does not exist; the file is damaged");
    histogram.add(bin, count);
    histogram.count_ += count;
  }
  return histogram;
}

double LatencyHistogram::middle_of(std::size_t bin) noexcept {
  if (bin < 2 * kBinsPerOctave) return static_cast<double>(bin);  // one value per bin
  const auto octave = static_cast<int>(bin / kBinsPerOctave) - 1;
  const auto mantissa = static_cast<double>(bin % kBinsPerOctave + kBinsPerOctave);
  return std::ldexp(mantissa + 0.5, octave) - 0.5;
}

std::int64_t LatencyHistogram::max_of(std::size_t bin) noexcept {
  if (bin < 2 * kBinsPerOctave) return static_cast<std::int64_t>(bin);
  const std::uint64_t mantissa = bin % kBinsPerOctave + kBinsPerOctave;
  return static_cast<std::int64_t>(((mantissa + 1) << (bin / kBinsPerOctave - 1)) - 1);
}

}  // namespace asap::inline v0_1
