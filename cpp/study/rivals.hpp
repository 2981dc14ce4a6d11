// The rivals of the benchmark: schemes that others have published or that a user might write first.
// Baselines of experiments, not products. Called on the consumer's thread; O(1) per package where
// nothing else is said; no allocation after construction.
#pragma once

#include <array>
#include <chrono>

#include "asap/runner/simulator.hpp"
#include "asap/schemes/scheme.hpp"
#include "core/check.hpp"
#include "schemes/bounded_scheme.hpp"

namespace asap {

// What the rivals share: a latency bound, their only parameter. The rule itself is theirs.
class Rival : public Scheme {
 public:
  explicit Rival(std::chrono::nanoseconds latency) : latency_ns_(checked_latency_ns(latency)) {}

  SchemeParameters parameters() const final {
    return {{"latency_ms", static_cast<double>(latency_ns_) / 1e6}};
  }
  std::int64_t latency_bound_ns() const noexcept final { return latency_ns_; }

 protected:
  const std::int64_t latency_ns_;
};

// GreedyClear: Greedy, but when the oldest event is older than L/2 at the moment the algorithm is
// free, everything older than 4 us is discarded first. What "drop the queue when late" comes to.
// O(log n) per package.
class GreedyClear final : public Rival {
 public:
  using Rival::Rival;

  Decision decide(const Backlog& backlog) noexcept override;
  std::string_view name() const noexcept override { return "greedy_clear"; }
};

// JaerTimer: after jAER's processing timer. Greedy, but the package stops when its timer of L/2 has
// run: n = max(1, (L/2/X - alpha)/beta) of the oldest events, where X and beta are the simulated
// package's own, which it knows; the rest of what waited when it started is discarded.
//
// A decision throws away the oldest only, so the rest goes first thing after the package; until
// then it keeps its place in the ring.
class JaerTimer final : public Rival {
 public:
  // The cost of the simulator that it will run in, from that simulator's first package on.
  JaerTimer(std::chrono::nanoseconds latency, LinearCost cost);

  Decision decide(const Backlog& backlog) noexcept override;
  void observe(const Outcome& outcome) noexcept override;
  void reset(Execution execution) noexcept override;
  std::string_view name() const noexcept override { return "jaer_timer"; }

 private:
  const LinearCost cost_;

  std::uint64_t packages_ = 0;
  std::size_t waited_ = 0;  // when last asked
  std::size_t rest_ = 0;    // of the last package's backlog, to be discarded
};

// SparkPid: the back-pressure of Spark Streaming: a batch every T = L/2, thinned to at most q T
// events, where q follows what the algorithm achieved,
//   v = n/c of a completed package;  q <- q - (q - v) - 0.2 (wait v / T),  q >= 0.05 v,
// wait = start of service minus close, first q = v.
//
// A push law in pull form: batches close at the multiples of T of run time and queue in the ring.
// Each is thinned with the q that was known when it closed, so the last values of q are kept. O(1)
// per package but for the few batches that queue.
class SparkPid final : public Rival {
 public:
  explicit SparkPid(std::chrono::nanoseconds latency);

  Decision decide(const Backlog& backlog) noexcept override;
  void observe(const Outcome& outcome) noexcept override;
  void reset(Execution execution) noexcept override;
  std::string_view name() const noexcept override { return "spark_pid"; }

 private:
  // q from a completion on.
  struct Limit {
    std::int64_t since_ns;
    double events_per_ns;
  };
  static constexpr std::size_t kLimits = 256;  // longer queues see a q that is too new

  std::int64_t close_after(std::int64_t time_ns) const noexcept;
  double most_events(std::int64_t close_ns) const noexcept;

  const std::int64_t period_ns_;  // T

  std::int64_t close_ns_ = 0;  // of the package that was last taken
  std::array<Limit, kLimits> limits_{};
  std::uint64_t limit_count_ = 0;
};

}  // namespace asap
