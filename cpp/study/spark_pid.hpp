// SparkPid: a rival of the benchmark, the back-pressure of Spark Streaming: a batch every T = L/2,
// thinned to at most q T events, where q follows what the algorithm achieved,
//   v = n/c of a completed package;  q <- q - (q - v) - 0.2 (wait v / T),  q >= 0.05 v,
// wait = start of service minus close, first q = v. A baseline of an experiment, not a product.
//
// A push law in pull form: batches close at the multiples of T of run time and queue in the ring.
// Each is thinned with the q that was known when it closed, so the last values of q are kept. O(1)
// per package but for the few batches that queue.
#pragma once

#include <array>

#include "study/rival.hpp"

namespace asap {

class SparkPid final : public Rival {
 public:
  explicit SparkPid(double latency_ms);

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
