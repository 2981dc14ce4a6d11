// LatencyHistogram: the distribution of the latency per event, in fixed memory. 128 bins per
// octave, so a quantile is within 0.4 % of the truth; count, mean, max and the count within the
// bound are exact. One thread records; a copy may be taken by any thread meanwhile. O(1) per event,
// no allocation after construction. The idea of HdrHistogram.
//
//   LatencyHistogram latencies(/*bound_ns=*/10'000'000);
//   latencies.record(1'200'000);
//   const double p99_ns = latencies.quantile_ns(0.99);
#pragma once

#include <algorithm>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

namespace asap::inline v0_1 {

class LatencyHistogram {
 public:
  LatencyHistogram() : LatencyHistogram(std::numeric_limits<std::int64_t>::max()) {}
  explicit LatencyHistogram(std::int64_t bound_ns);
  LatencyHistogram(const LatencyHistogram& other);
  LatencyHistogram& operator=(const LatencyHistogram& other) noexcept;
  static constexpr std::size_t memory_bytes() noexcept { return kBins * sizeof(std::uint64_t); }

  // Forgets all, in place.
  void clear(std::int64_t bound_ns) noexcept;

  // `count` events of the same latency, 1 to 2^32 - 1. A negative one (a timestamp ahead of the
  // clock) counts as 0.
  void record(std::int64_t latency_ns, std::size_t count = 1) noexcept {
    latency_ns = std::max<std::int64_t>(latency_ns, 0);
    const auto value = static_cast<std::uint64_t>(latency_ns);
    add(bin_of(value), count);
    Batch batch(*this);
    batch.count_ = count;
    batch.within_bound_ = latency_ns <= bound_ns_ ? count : 0U;
    batch.max_ns_ = latency_ns;
    // value * count in 128 bits, from halves of 32
    const std::uint64_t low = (value & 0xffff'ffffU) * count;  // count < 2^32
    const std::uint64_t high = (value >> 32) * count;
    batch.sum_low_ = value * count;
    batch.sum_high_ = (high + (low >> 32)) >> 32;
  }

  // Many events of their own latencies: the sums are booked once, when the batch ends.
  class Batch {
   public:
    explicit Batch(LatencyHistogram& histogram) noexcept
        : histogram_(histogram), bound_ns_(histogram.bound_ns_) {}
    ~Batch() { histogram_.book(*this); }
    Batch(const Batch&) = delete;
    Batch& operator=(const Batch&) = delete;

    void record(std::int64_t latency_ns) noexcept {
      latency_ns = std::max<std::int64_t>(latency_ns, 0);
      const auto value = static_cast<std::uint64_t>(latency_ns);
      histogram_.add(bin_of(value), 1);
      ++count_;
      within_bound_ += latency_ns <= bound_ns_ ? 1U : 0U;
      max_ns_ = std::max(max_ns_, latency_ns);
      sum_low_ += value;
      sum_high_ += sum_low_ < value ? 1U : 0U;
    }

   private:
    friend class LatencyHistogram;
    LatencyHistogram& histogram_;
    const std::int64_t bound_ns_;
    std::uint64_t count_ = 0;
    std::uint64_t within_bound_ = 0;
    std::int64_t max_ns_ = 0;
    std::uint64_t sum_low_ = 0;
    std::uint64_t sum_high_ = 0;
  };

  std::uint64_t count() const noexcept { return count_; }
  std::uint64_t within_bound() const noexcept { return within_bound_; }
  // Any thread.
  std::int64_t bound_ns() const noexcept {
    return std::atomic_ref(const_cast<std::int64_t&>(bound_ns_)).load(std::memory_order_relaxed);
  }
  // Later events are counted within_bound() by this bound.
  void set_bound_ns(std::int64_t bound_ns) noexcept;
  std::int64_t max_ns() const noexcept { return max_ns_; }
  // 0 if nothing is recorded.
  double mean_ns() const noexcept;
  // The smallest latency that at least the fraction q of the events do not exceed; never above
  // max_ns(). 0 if nothing is recorded. Throws std::invalid_argument unless 0 <= q <= 1.
  double quantile_ns(double q) const;

  // Returns what was recorded since an earlier copy of this histogram, its max_ns() exact to a bin.
  LatencyHistogram since(const LatencyHistogram& earlier) const;

  // All that is recorded, to be kept in a file: the counts of the bins that are not empty.
  struct State {
    std::int64_t bound_ns;
    std::int64_t max_ns;
    std::uint64_t within_bound;
    std::uint64_t sum_low;
    std::uint64_t sum_high;
    std::vector<std::pair<std::uint32_t, std::uint64_t>> bins;
  };
  State state() const;
  // Throws std::invalid_argument for a bin that does not exist.
  static LatencyHistogram restored(const State& state);

 private:
  static constexpr int kMantissaBits = 7;
  static constexpr std::size_t kBinsPerOctave = std::size_t{1} << kMantissaBits;
  static constexpr std::size_t kBins = kBinsPerOctave * (64 - kMantissaBits);

  static constexpr std::size_t bin_of(std::uint64_t value) noexcept {
    const int octave = std::max(static_cast<int>(std::bit_width(value)) - kMantissaBits - 1, 0);
    return static_cast<std::size_t>(octave) * kBinsPerOctave +
           static_cast<std::size_t>(value >> octave);
  }
  template <class Number>
  static void store(Number& number, Number value) noexcept {
    std::atomic_ref(number).store(value, std::memory_order_relaxed);
  }
  void add(std::size_t bin, std::uint64_t count) noexcept { store(bins_[bin], bins_[bin] + count); }
  void book(const Batch& batch) noexcept {
    const std::uint64_t sum_low = sum_low_ + batch.sum_low_;
    const std::uint64_t carry = sum_low < batch.sum_low_ ? 1 : 0;
    store(count_, count_ + batch.count_);
    store(within_bound_, within_bound_ + batch.within_bound_);
    store(max_ns_, std::max(max_ns_, batch.max_ns_));
    store(sum_low_, sum_low);
    store(sum_high_, sum_high_ + batch.sum_high_ + carry);
  }
  static double middle_of(std::size_t bin) noexcept;
  static std::int64_t max_of(std::size_t bin) noexcept;

  std::int64_t bound_ns_;
  std::vector<std::uint64_t> bins_;
  std::uint64_t count_ = 0;
  std::uint64_t within_bound_ = 0;
  std::int64_t max_ns_ = 0;
  std::uint64_t sum_low_ = 0;
  std::uint64_t sum_high_ = 0;
};

}  // namespace asap::inline v0_1
