// GreedyClear: a rival of the benchmark. Greedy, but when the oldest event is older than L/2 at the
// moment the algorithm is free, everything older than 4 us is discarded first. What "drop the
// queue when late" comes to. A baseline of an experiment, not a product. O(log n) per package.
#pragma once

#include "asap/schemes/scheme.hpp"

namespace asap {

class GreedyClear final : public Scheme {
 public:
  explicit GreedyClear(double latency_ms);

  Decision decide(const Backlog& backlog) noexcept override;
  std::string_view name() const noexcept override { return "greedy_clear"; }
  SchemeParameters parameters() const override { return {{"latency_ms", latency_ms_}}; }
  std::int64_t latency_bound_ns() const noexcept override { return latency_ns_; }

 private:
  const double latency_ms_;
  const std::int64_t latency_ns_;
};

}  // namespace asap
