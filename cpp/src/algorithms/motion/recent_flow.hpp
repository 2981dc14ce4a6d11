// RecentFlow: the latest flow events, in the order of time, in one piece. When the memory is full
// the oldest goes. One thread. O(1), amortised; allocates in the constructor only.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "algorithms/motion/background_motion.hpp"

namespace asap::inline v0_1::motion {

class RecentFlow {
 public:
  explicit RecentFlow(std::size_t most) : most_(most), samples_(2 * most) {}

  void add(const FlowSample& sample) noexcept {
    if (end_ - begin_ == most_) ++begin_;
    if (end_ == samples_.size()) {
      std::copy(samples_.begin() + offset(begin_), samples_.end(), samples_.begin());
      end_ -= begin_;
      begin_ = 0;
    }
    samples_[end_++] = sample;
  }

  void forget_before(std::int64_t t) noexcept {
    while (begin_ < end_ && samples_[begin_].t < t) ++begin_;
  }

  std::span<const FlowSample> samples() const noexcept {
    return std::span(samples_).subspan(begin_, end_ - begin_);
  }

  void clear() noexcept { begin_ = end_ = 0; }

 private:
  static std::ptrdiff_t offset(std::size_t index) { return static_cast<std::ptrdiff_t>(index); }

  std::size_t most_;
  std::vector<FlowSample> samples_;
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
};

}  // namespace asap::inline v0_1::motion
