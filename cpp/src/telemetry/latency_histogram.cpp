#include "asap/telemetry/latency_histogram.hpp"

#include <cmath>

#include "core/check.hpp"

namespace asap {

double LatencyHistogram::mean_ns() const noexcept {
  if (count_ == 0) return 0.0;
  const double sum =
      static_cast<double>(sum_high_.load()) * 0x1.0p64 + static_cast<double>(sum_low_.load());
  return sum / static_cast<double>(count_.load());
}

double LatencyHistogram::quantile_ns(double q) const {
  require(q >= 0.0 && q <= 1.0, "q", q, "must be a number between 0 and 1");
  if (count_ == 0) return 0.0;
  const double wanted = std::ceil(q * static_cast<double>(count_.load()));
  const std::uint64_t rank = std::max<std::uint64_t>(static_cast<std::uint64_t>(wanted), 1);
  if (rank >= count_) return static_cast<double>(max_ns_.load());
  std::uint64_t seen = 0;
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    seen += bins_[bin];
    if (seen >= rank) return std::min(middle_of(bin), static_cast<double>(max_ns_.load()));
  }
  return static_cast<double>(max_ns_.load());
}

LatencyHistogram LatencyHistogram::since(const LatencyHistogram& earlier) const {
  LatencyHistogram later(bound_ns_);
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    const std::uint64_t count = bins_[bin] - earlier.bins_[bin];
    if (count == 0) continue;
    later.bins_.add(bin, count);
    later.count_ += count;
    later.max_ns_ = std::min(max_of(bin), max_ns_.load());
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
    histogram.bins_.add(bin, count);
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

}  // namespace asap
