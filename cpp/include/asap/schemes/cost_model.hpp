// CostModel: what a package of n events will cost, learned from what packages did cost,
// c(n) = alpha + beta n (ASAP control reference, 6.3). Times are ns.
//
// In closed loop n hardly varies, and then alpha and beta are not separately observable: a plain
// recursive fit runs away. Here each octave of n has a bucket of its own that is overwritten only
// when its sizes come back, so old evidence about other sizes stays. The line is a weighted least
// squares fit through the buckets; a fast common scale follows a cost that varies as a whole.
// Single outliers are clipped, the third in a row on one side is a new level; one that is more than
// three times as dear, or less than half as dear, is learned anew, but for a fall that the fixed
// cost alone explains and for sizes far beyond those that have come since. What is known to be an
// outage is no cost (Outcome::outage_ns): an anytime package ends on time with fewer events,
// whatever kept it, and its time would pass for a fixed cost. The reference takes the wall time.
//
// Called on the consumer's thread, once per package. O(1), no allocation. Whatever is fed, the
// estimates are positive and finite.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace asap {

struct CostModelConfig {
  double first_alpha_us = 50.0;  // assumed before the first package; forgotten after six
  double first_beta_ns = 100.0;
};

class CostModel {
 public:
  explicit CostModel(CostModelConfig config = {});

  // A package of `size` events took processing_ns. What is no time (NaN, negative) is ignored.
  void update(std::size_t size, double processing_ns) noexcept;
  void reset() noexcept;

  double alpha_ns() const noexcept { return scale_ * alpha_ns_; }
  double beta_ns() const noexcept { return scale_ * beta_ns_; }
  double predict_ns(double size) const noexcept { return scale_ * line_ns(size); }
  // Relative noise of the package times.
  double sigma() const noexcept { return sigma_; }
  // Packages learned from.
  std::uint64_t count() const noexcept { return count_; }

 private:
  struct Bucket {
    double weight;
    double size;     // mean of its packages
    double cost_ns;  // likewise
    bool is_prior;   // not measured
  };

  double line_ns(double size) const noexcept { return alpha_ns_ + beta_ns_ * size; }
  double clipped(double error, double size) noexcept;
  void forget() noexcept;
  bool knows_better(const Bucket& prior) const noexcept;
  void remember(double size, double cost_ns) noexcept;
  void fit() noexcept;
  void follow(double size, double cost_ns, double noise) noexcept;
  void rebase(double factor) noexcept;
  void start_level(double factor, double size) noexcept;
  std::uint64_t on_level() const noexcept { return count_ - level_start_; }

  const CostModelConfig config_;
  double alpha_ns_;
  double beta_ns_;
  double scale_;
  double sigma_;
  int streak_;    // outliers in a row: > 0 too slow, < 0 too fast
  double least_;  // the smallest error of them
  std::uint64_t count_;
  std::uint64_t level_start_;  // count_ when the present level began
  double smallest_;            // size since then
  double largest_;
  std::array<Bucket, 24> buckets_;  // by log2 of the size
};

}  // namespace asap
