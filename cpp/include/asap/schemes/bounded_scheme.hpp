// BoundedScheme: what DeadBeat and Deadline share: the latency bound in force, the wait before a
// package (hold.hpp), the learned cost of a package and how often it was measured. The law itself
// is theirs.
//
// Called on the consumer's thread; any thread may read and set the bound. O(1), no allocation.
#pragma once

#include "asap/core/atomics.hpp"
#include "asap/schemes/cost_model.hpp"
#include "asap/schemes/hold.hpp"
#include "asap/schemes/scheme.hpp"

namespace asap {

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
  // Of a configuration with latency_ms, overhead, min_interval_ms and knee; checks these.
  template <class Config>
  explicit BoundedScheme(const Config& config, CostModelConfig cost = {})
      : BoundedScheme(config.latency_ms, config.overhead, config.min_interval_ms, config.knee,
                      cost) {}

  // The configuration's parameters, with the bound in force.
  template <class Config>
  SchemeParameters parameters_in_force(Config config) const {
    config.latency_ms = latency_ms(config.latency_ms);
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

 private:
  BoundedScheme(double latency_ms, double overhead, double min_interval_ms, double knee,
                CostModelConfig cost);
  double latency_ms(double configured_ms) const noexcept;
};

}  // namespace asap
