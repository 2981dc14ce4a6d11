// GreedyRateGamma: a rival of the benchmark. Greedy behind an input filter that knows what the
// algorithm can do: gamma = min(1, mu / lambda), mu = max((1 - 2 alpha/L)/beta, 0.05/beta), with
// alpha and beta learned and lambda the exponential average of the raw rate over 5 ms, refreshed
// every 32 us. A baseline of an experiment, not a product: only the simulator has a filter on
// admission. O(1) per package and per refresh.
#pragma once

#include "asap/schemes/cost_model.hpp"
#include "runner/admission.hpp"
#include "study/rival.hpp"

namespace asap {

class GreedyRateGamma final : public Rival, public Admission {
 public:
  using Rival::Rival;

  Decision decide(const Backlog& backlog) noexcept override {
    return Decision::take(backlog.count);
  }
  void observe(const Outcome& outcome) noexcept override;
  void reset(Execution execution) noexcept override;
  std::string_view name() const noexcept override { return "greedy_rate_gamma"; }

  double gamma(const Arrivals& arrivals) noexcept override;
  std::int64_t period_ns() const noexcept override { return 32'000; }

 private:
  CostModel cost_;
  double rate_ = 0.0;  // lambda, events per ns
};

}  // namespace asap
