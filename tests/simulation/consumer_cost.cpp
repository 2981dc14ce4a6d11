#include "consumer_cost.hpp"

#include <cmath>

namespace asap::simulation {
namespace {

constexpr std::size_t kOddShapes = 4;  // the last: a clock that steps back

std::size_t odd_shape(const Fault& fault) { return fault.draw().below(kOddShapes); }

}  // namespace

void ConsumerCost::begin(std::size_t position) noexcept {
  is_odd_ = false;
  factor_ = 1 + setup_.cost_noise * (2 * draw_.uniform() - 1);
  for (const Fault& fault : faults_) {
    if (!fault.acts(position)) continue;
    is_odd_ |= fault.kind == FaultKind::slower || fault.kind == FaultKind::odd_cost;
    if (fault.kind == FaultKind::slower) factor_ *= fault.draw().octaves(2, 100);
    if (fault.kind != FaultKind::odd_cost) continue;
    const double u = draw_.uniform();
    const std::size_t shape = odd_shape(fault);
    if (shape == 0) factor_ /= std::sqrt(1 - u);  // Pareto
    if (shape == 1) factor_ *= u < 0.1 ? 50 : 1;
    if (shape == 2) factor_ *= u < 0.5 ? 0 : 1;
  }
}

std::int64_t ConsumerCost::stall_ns(std::size_t position) noexcept {
  std::int64_t sum_ns = 0;
  for (std::size_t i = 0; i < faults_.size(); ++i) {
    if (faults_[i].kind != FaultKind::stall || stalled_[i] || !faults_[i].acts(position)) continue;
    stalled_[i] = true;
    Draw draw = faults_[i].draw();
    const std::size_t how = draw.below(4);
    sum_ns += how == 0   ? 10'000'000
              : how == 1 ? 1'000'000'000
                         : setup_.latency_ns * draw.between(1, 20);
  }
  return sum_ns;
}

std::int64_t ConsumerCost::step_back_ns(std::size_t position) noexcept {
  for (const Fault& fault : faults_) {
    if (fault.kind != FaultKind::odd_cost || !fault.acts(position)) continue;
    if (odd_shape(fault) != kOddShapes - 1 || !draw_.chance(0.1)) continue;
    return draw_.between(0, 2 * setup_.latency_ns);
  }
  return 0;
}

}  // namespace asap::simulation
