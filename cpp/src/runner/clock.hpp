// RunClock: the steady clock on the run's axis. The producer starts it before the first push; the
// consumer may read it once it has seen an event.
#pragma once

#include <chrono>
#include <cstdint>

#include "asap/core/time.hpp"
#include "runner/system.hpp"

namespace asap::inline v0_1 {

class RunClock {
 public:
  using Steady = System::Clock;

  // Now, or `start`, is run time `now_ns`.
  void start(std::int64_t now_ns, Steady::time_point start = System::now()) noexcept {
    steady_start_ = start;
    run_start_ns_ = now_ns;
  }

  std::int64_t now_ns() const noexcept { return at(System::now()); }

  // Run time of a time of the steady clock.
  std::int64_t at(Steady::time_point time) const noexcept {
    return run_start_ns_ + std::chrono::nanoseconds(time - steady_start_).count();
  }

  // When the steady clock shows this run time; what is centuries away stays out of reach.
  Steady::time_point when(std::int64_t run_ns) const noexcept {
    if (run_ns > kNever / 2) return Steady::time_point::max();
    return steady_start_ + std::chrono::nanoseconds(run_ns - run_start_ns_);
  }

 private:
  Steady::time_point steady_start_{};
  std::int64_t run_start_ns_ = 0;
};

}  // namespace asap::inline v0_1
