// Rival: what the rivals of the benchmark share: a latency bound, their only parameter. The rule
// itself is theirs. A baseline of an experiment, not a product.
#pragma once

#include "asap/schemes/scheme.hpp"
#include "schemes/latency_bound.hpp"

namespace asap {

class Rival : public Scheme {
 public:
  explicit Rival(double latency_ms)
      : latency_ms_(latency_ms), latency_ns_(checked_latency_ns(latency_ms)) {}

  SchemeParameters parameters() const final { return {{"latency_ms", latency_ms_}}; }
  std::int64_t latency_bound_ns() const noexcept final { return latency_ns_; }

 private:
  const double latency_ms_;

 protected:
  const std::int64_t latency_ns_;
};

}  // namespace asap
