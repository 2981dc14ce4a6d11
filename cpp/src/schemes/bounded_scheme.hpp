// BoundedScheme: what DeadBeat and Deadline share: the latency bound in force, the wait before a
// package (HoldRule), the learned cost of a package and how often it was measured. The law itself
// is theirs.
//
// Called on the consumer's thread; any thread may read and set the bound. O(1), no allocation.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>

#include "asap/schemes/scheme.hpp"
#include "core/atomics.hpp"

namespace asap::inline v0_1 {

// CostModel: what a package of n events will cost, learned from what packages did cost,
// c(n) = X (alpha + beta n). The line is the cost of a call that nothing disturbs; X is the mean
// factor by which noise, pauses and collectors raise it. Times are ns.
//
// In closed loop n hardly varies, and then alpha and beta are not separately observable: a plain
// recursive fit runs away. So the model remembers one cost for each power of two of n and updates
// it only when such sizes occur: a low expectile, which follows quick packages at once and slow
// ones reluctantly, because an interruption only makes a package slower. The line is a weighted
// least squares fit through these costs. X is a common factor, which also follows a cost that
// varies as a whole. An anytime package shows two sizes at once, its first part and all of it.
// Single outliers are clipped. Low times of new sizes and of single events are trusted. The third
// outlier in a row on one side is a new level.
// A level above three times or below half of the old one is learned anew, unless the fixed cost
// alone explains the fall; sizes far beyond the recent ones keep their buckets. Known outages are
// subtracted first, or they would pass for a fixed cost.
// Called on the consumer's thread, once per package. O(1), no allocation. Whatever is fed, the
// estimates are positive and finite. Source: notebooks/theory.md, section 8.
struct CostModelConfig {
  double first_alpha_us = 50.0;  // assumed before the first package; forgotten after six
  double first_beta_ns = 100.0;
};

class CostModel {
 public:
  explicit CostModel(CostModelConfig config = {});

  // Learns from the time that a package's work took, outages excluded. Ignores a package without
  // events or with a negative time.
  void update(const Outcome& outcome) noexcept;
  void reset() noexcept;

  // The cost of the mean package, what disturbs it included.
  double alpha_ns() const noexcept { return scale_ * alpha_ns_; }
  double beta_ns() const noexcept { return scale_ * beta_ns_; }
  // The fixed cost of a package that nothing disturbs.
  double undisturbed_alpha_ns() const noexcept { return alpha_ns_; }
  // The share of beta that is claimed: none below its standard error, all of it from twice that on,
  // and all while the first guess is in it.
  double certainty() const noexcept;
  // Whether the sizes seen tell the fixed cost from that of the events, to a quarter of it.
  bool knows_alpha() const noexcept { return beta_error_ns_ * recent_size() <= alpha_ns_ / 4; }
  // The largest package worth a try where the events seem to cost nothing: twice the largest that
  // is remembered, and such that it ends within room_ns if that is wrong and nothing disturbs it.
  double trial_size(double room_ns) const noexcept;
  double predict_ns(double size) const noexcept { return scale_ * line_ns(size); }
  // Upper bound on the cost of an event, its share of the fixed cost included, in packages at least
  // as large as recent ones. It holds however wrong the line is. Infinite before the first package.
  double max_event_ns() const noexcept { return max_event_ns_; }
  // Beta once the line rests on measured packages; until then the larger of beta and that bound.
  double doubted_event_ns() const noexcept;
  // The largest package that ends within room_ns even if the line is wrong; at least 2. What it
  // costs is taken times `fixed_caution` up to the size of the largest recent package and times
  // `event_caution` beyond. Returns at once where `enough` events are safe: no more are asked for.
  // Source: notebooks/theory.md, section 8.
  double safe_size(double room_ns, double fixed_caution, double event_caution,
                   double enough = std::numeric_limits<double>::infinity()) const noexcept;
  // What the largest recent package took. 0 before the first.
  double recent_cost_ns() const noexcept { return recent_cost_ns_; }
  // Relative noise of the package times.
  double sigma() const noexcept { return sigma_; }
  // Packages learned from, first parts included.
  std::uint64_t count() const noexcept { return count_; }

 private:
  struct Bucket {
    double weight;
    double size;     // mean of its packages
    double cost_ns;  // of those that nothing disturbed
    bool is_prior;   // not measured

    bool is_new() const noexcept { return weight < 0.2; }
  };

  // Packages that were measured: their weight, and their mean size and cost.
  struct Mean {
    double weight = 0.0;
    double size = 0.0;
    double cost_ns = 0.0;
  };

  struct Gains {
    double scale;
    double sigma;
  };

  void learn(std::size_t size, std::int64_t time_ns, Gains gains) noexcept;
  double line_ns(double size) const noexcept { return alpha_ns_ + beta_ns_ * size; }
  void watch(double size, double cost_ns) noexcept;
  double clipped(double error, double size) noexcept;
  double min_cost_ns() const noexcept;
  double recent_size() const noexcept { return recent_cost_ns_ / max_event_ns_; }
  Mean smaller_packages() const noexcept;
  double max_beta_ns(const Mean& small) const noexcept;
  void forget() noexcept;
  bool knows_better(const Bucket& prior) const noexcept;
  double undisturbed_event_ns() const noexcept;
  Bucket& bucket(double size) noexcept;
  template <class Self, class Call>
  static void each_asked_for(Self& self, const Call& call) noexcept;
  void remember(double size, double cost_ns) noexcept;
  void fit() noexcept;
  void follow(double size, double cost_ns, double noise, Gains gains) noexcept;
  void rebase(double factor) noexcept;
  void start_level(double factor, double size) noexcept;
  std::uint64_t on_level() const noexcept { return count_ - level_start_; }

  const CostModelConfig config_;
  double alpha_ns_;
  double beta_ns_;
  double beta_error_ns_;  // standard error of beta
  double scale_;          // X
  double sigma_;
  int streak_;        // outliers in a row: > 0 too slow, < 0 too fast
  double min_error_;  // the smallest error of them
  std::uint64_t count_;
  std::uint64_t level_start_;  // count_ when the present level began
  double smallest_;            // size since then
  double largest_;
  bool guess_holds_;                // so far each package has cost what was assumed at first
  double recent_size_;              // of the largest recent package; it fades
  double recent_cost_ns_;           // what it took
  double max_event_ns_;             // the same by event
  std::array<Bucket, 24> buckets_;  // by log2 of the size
  std::uint32_t asked_for_;         // a bit for each; the others are empty
};

// ---- what the two schemes share

// Since the start of the last package; kNever before the first.
std::int64_t interval_ns(const Backlog& backlog) noexcept;

// Whether a free algorithm shall wait before the next package (notebooks/theory.md, section 3).
// Packages cost a fixed time each; waiting for alpha / overhead between two starts limits the share
// of the processor that goes into it, and `min_interval` limits the number of packages. Never
// longer than half the latency bound, and no longer than it takes to have enough events for an
// efficient package. The oldest event never waits longer either, so a quiet scene is flushed. Pure.
class HoldRule {
 public:
  // overhead: permitted share of fixed costs, 0 = any. min_interval: between package starts.
  HoldRule(double overhead, std::chrono::nanoseconds min_interval);

  // The wait, or nothing: start now. `caution` (zeta) times the predicted cost is planned with.
  std::optional<Decision> wait(const Backlog& backlog, const CostModel& cost, double caution,
                               double latency_ns) const noexcept;

  // The shortest time between two package starts: min_interval, but never more than half the bound.
  double shortest_ns(double latency_ns) const noexcept;
  // The longest time between two package starts that is waited for.
  double longest_ns(const CostModel& cost, double latency_ns) const noexcept;

 private:
  const double overhead_;
  const double min_interval_ns_;
};

// Decides when a package of one event measures the fixed cost: where packages end late and the
// estimate blames the fixed cost. Each probe that confirms it doubles the distance to the next one,
// so 1 in 16 to 1 in 16,384 packages are probes.
class FixedCostProbe {
 public:
  bool is_due(std::uint64_t package, double alpha_ns, double bound_ns) noexcept;
  // That package has ended: the age of its oldest event, the time of its work, and the fixed cost
  // that was believed before.
  void observe(std::uint64_t package, double latency_ns, double bound_ns, double work_ns,
               double alpha_ns) noexcept;

 private:
  static constexpr std::uint64_t kShortest = 16;  // packages
  static constexpr std::uint64_t kLongest = 16'384;

  std::uint64_t next_ = 0;
  std::uint64_t distance_ = kShortest;
  bool was_late_ = false;
  bool is_measuring_ = false;
};

class BoundedScheme : public Scheme {
 public:
  void observe(const Outcome& outcome) noexcept override;
  void reset(Execution execution) noexcept override;
  std::int64_t latency_bound_ns() const noexcept final { return latency_bound_ns_; }
  void set_latency_bound_ns(std::int64_t bound_ns) noexcept final { latency_bound_ns_ = bound_ns; }

  // What a package costs, as far as it is known.
  double alpha_ns() const noexcept { return cost_.alpha_ns(); }
  double beta_ns() const noexcept { return cost_.beta_ns(); }

 protected:
  // The configuration has latency, overhead and min_interval, which are checked here.
  template <class Config>
  explicit BoundedScheme(const Config& config, CostModelConfig cost = {})
      : BoundedScheme(config.latency, config.overhead, config.min_interval, cost) {}

  // The configuration's parameters, with the bound in force.
  template <class Config>
  SchemeParameters parameters_in_force(Config config) const {
    config.latency = std::chrono::nanoseconds(latency_bound_ns_);
    return parameters_of(config);
  }

  bool is_whole() const noexcept { return execution_ == Execution::whole; }
  // The decision of an anytime package, which is to end budget_ns after its start.
  Decision within(double budget_ns, Decision decision) const noexcept;

  Relaxed<std::int64_t> latency_bound_ns_;
  const HoldRule hold_;
  CostModel cost_;
  Execution execution_ = Execution::whole;
  std::uint64_t packages_ = 0;  // k, done
  double age_ns_ = 0.0;         // age of the oldest event in the last package decided
  FixedCostProbe probe_;

 private:
  BoundedScheme(std::chrono::nanoseconds latency, double overhead,
                std::chrono::nanoseconds min_interval, CostModelConfig cost);
};

}  // namespace asap::inline v0_1
