// ReservoirPrice: how much of the reservoir is worth its price. While an overload lasts, a law that
// keeps a reservoir runs shorter packages than it could, and pays for it in fixed costs; what it
// gains comes at the end, once: the work that was left to serve, half a latency bound or less. So
// the reservoir is given up as its price comes near that, as who rents skis for as long as they
// would cost; and from the start where overloads have, on average, cost as much. Without a
// parameter. Called by a scheme; O(1), no allocation.
#pragma once

#include <algorithm>

namespace asap {

class ReservoirPrice {
 public:
  // The price of a thinned package: of its fixed costs, those that a longer one would have saved.
  void pay(double ns) noexcept { paid_ns_ += ns; }

  // The overload is over.
  void settle() noexcept {
    if (paid_ns_ == 0.0) return;
    past_ns_ = kMemory * past_ns_ + paid_ns_;
    overloads_ = kMemory * overloads_ + 1.0;
    paid_ns_ = 0.0;
  }

  // The fraction of the reservoir that is worth keeping: 1 in short overloads, 0 in long ones.
  double share(double latency_ns) const noexcept {
    const double usual_ns = overloads_ > 0.0 ? past_ns_ / overloads_ : 0.0;
    return std::max(0.0, 1.0 - std::max(paid_ns_, usual_ns) / (kWorth * latency_ns));
  }

 private:
  static constexpr double kWorth = 0.5;   // bounds
  static constexpr double kMemory = 0.9;  // weight of the last overload against the one before

  double paid_ns_ = 0.0;    // in the present overload
  double past_ns_ = 0.0;    // discounted sum over the overloads before
  double overloads_ = 0.0;  // their discounted number
};

}  // namespace asap
