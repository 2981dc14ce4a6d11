// GreedyPie: a rival of the benchmark. Greedy behind an input filter that is steered like the queue
// discipline PIE (RFC 8033): every 1 ms, with d = age in s of the oldest waiting event,
//   p <- clip(p + 20 (d - L/2) + [d + d_old > 0.2 ms] 200 (d - d_old), 0, 0.99),  gamma = 1 - p
// A baseline of an experiment, not a product: only the simulator has a filter on admission. O(1)
// per package and per ms.
#pragma once

#include "runner/admission.hpp"
#include "study/rival.hpp"

namespace asap {

class GreedyPie final : public Rival, public Admission {
 public:
  using Rival::Rival;

  Decision decide(const Backlog& backlog) noexcept override {
    return Decision::take(backlog.count);
  }
  void reset(Execution execution) noexcept override;
  std::string_view name() const noexcept override { return "greedy_pie"; }

  double gamma(const Arrivals& arrivals) noexcept override;
  std::int64_t period_ns() const noexcept override { return 1'000'000; }

 private:
  double drop_ = 0.0;   // p
  double age_s_ = 0.0;  // d, when last asked
};

}  // namespace asap
