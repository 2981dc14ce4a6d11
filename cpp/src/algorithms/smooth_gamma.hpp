// SmoothGamma: the share of the latest events that thinning kept, for what an algorithm scales with
// it: windows and thresholds stand for many packages, and gamma of one package is as short-lived as
// the package. A mean over events, not over time: of those that came, by those that were there. The
// first gamma told holds at once. One thread, O(1) per call; the results are the same bits
// everywhere.
#pragma once

#include <algorithm>
#include <cstddef>

namespace asap::inline v0_1 {

class SmoothGamma {
 public:
  static constexpr double kMemory = 16'000;  // events

  // Sets the gamma of the events that come from now on. 0 counts as 1e-9.
  void tell(double gamma) noexcept { told_ = std::max(gamma, 1e-9); }

  // So many more events have come. Returns whether value() has changed.
  bool take(std::size_t events) noexcept {
    const auto more = static_cast<double>(events);
    const double before = value_;
    if (told_ != value_ && more > 0) {
      value_ = seen_ == 0 ? told_ : (seen_ + more) / (seen_ / value_ + more / told_);
    }
    seen_ = std::min(seen_ + more, kMemory);
    return value_ != before;
  }

  double value() const noexcept { return value_; }

 private:
  double told_ = 1;
  double value_ = 1;
  double seen_ = 0;  // events that value_ is the mean of, up to kMemory
};

}  // namespace asap::inline v0_1
