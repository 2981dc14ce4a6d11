// OutageReserve: the part of the latency bound that is left free for outages. On a busy machine the
// thread is taken off the processor for milliseconds, again and again; what is in work then ends as
// much too late, and no replanning makes up for an outage at the end of a package. So the scheme
// plans with a shorter bound: the reserve grows while more than a few in a thousand events are
// late, and shrinks while fewer are. Where outages are rare it is zero and costs nothing. It has no
// parameter. O(1) per package.
#pragma once

#include <algorithm>

namespace asap::inline v0_1 {

class OutageReserve {
 public:
  // A package ended with its oldest event latency_ns old, its newest span_ns less. bound_ns is what
  // can be kept: a cost that breaks the bound is no outage.
  void observe(double latency_ns, double span_ns, double bound_ns) noexcept {
    const double late_ns = latency_ns - bound_ns;
    const bool is_late = late_ns > kGrace * bound_ns;
    const double late = is_late ? std::min(late_ns / std::max(span_ns, 1.0), 1.0) : 0.0;
    share_ = std::clamp(share_ + kGain * (late - kTolerated), 0.0, kMax);
  }

  // The reserve of a bound; at most what leaves room for four fixed costs.
  double ns(double bound_ns, double alpha_ns) const noexcept {
    return std::clamp(bound_ns - 4.0 * alpha_ns, 0.0, share_ * bound_ns);
  }

 private:
  static constexpr double kGain = 0.05;   // step in bounds for a package that is late as a whole
  static constexpr double kGrace = 0.01;  // share of the bound below which lateness is no outage
  static constexpr double kTolerated = 0.005;  // so that p99 is within the bound
  static constexpr double kMax = 0.5;          // shorter packages cost more than they save

  double share_ = 0.0;
};

}  // namespace asap::inline v0_1
