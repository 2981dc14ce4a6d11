// ConsumerCost: what the simulated algorithm needs for a package, with the faults of a consumer:
// slower, odd distributions, stalls. Whole numbers of ns.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "faults.hpp"

namespace asap::simulation {

class ConsumerCost {
 public:
  ConsumerCost(const Setup& setup, const std::vector<Fault>& faults)
      : setup_(setup), faults_(faults), draw_(setup.seed, 7), stalled_(faults.size(), false) {}

  // Draws for the next package; the source has sent `position` events.
  void begin(std::size_t position) noexcept;
  // Whether a fault acts on what the package costs.
  bool is_odd() const noexcept { return is_odd_; }
  // Of the package that has begun.
  std::int64_t fixed_ns() const noexcept { return whole_ns(factor_ * setup_.alpha_ns); }
  std::int64_t of_ns(std::size_t size) const noexcept {
    return whole_ns(factor_ * setup_.beta_ns * static_cast<double>(size));
  }
  // Once per stall.
  std::int64_t stall_ns(std::size_t position) noexcept;
  // How far a look at a clock that steps back is off.
  std::int64_t step_back_ns(std::size_t position) noexcept;

 private:
  static std::int64_t whole_ns(double cost_ns) noexcept {
    return static_cast<std::int64_t>(std::min(cost_ns, 1e15));
  }

  const Setup& setup_;
  const std::vector<Fault>& faults_;
  Draw draw_;
  double factor_ = 1;
  bool is_odd_ = false;
  std::vector<bool> stalled_;  // faults
};

}  // namespace asap::simulation
