// SupportMap: when each pixel fired last; an event has support if one of its eight neighbours, of
// either polarity, fired at most a window ago. Its own pixel does not count, so one that flashes
// alone never has. One thread. O(1) per event, allocates in the constructor only.
// Source: the rule of BackgroundActivityFilter (Delbruck 2008), here on stamps modulo 2^32.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "algorithms/fast/stamp.hpp"
#include "algorithms/int4.hpp"

namespace asap::fast {

class SupportMap {
 public:
  SupportMap(int width, int height)
      : stride_(static_cast<std::size_t>(width) + 2),
        // Rows are read four pixels at a time where three are meant.
        stamps_(stride_ * (static_cast<std::size_t>(height) + 2) + 1),
        scrubber_(stamps_.size()) {}

  void clear(Stamp now) noexcept {
    std::fill(stamps_.begin(), stamps_.end(), static_cast<std::int32_t>(long_before(now)));
  }

  // Whether the pixel, which lies in the frame, has support; then it fires itself.
  bool touch(std::size_t x, std::size_t y, Stamp now, std::int32_t window_us) noexcept {
    std::int32_t* own = stamps_.data() + (y + 1) * stride_ + x + 1;
    const auto time = static_cast<std::int32_t>(now);
    const auto young = [&](const std::int32_t* row) {
      return Int4::mask_young(Int4::load(row - 1), time, window_us);
    };
    const std::uint32_t outer = young(own - stride_) | young(own + stride_);
    const bool support = ((outer & 0b111) | (young(own) & 0b101)) != 0;
    *own = time;
    return support;
  }

  void scrub(Stamp now, std::uint64_t elapsed_us) noexcept {
    scrubber_.advance(elapsed_us, [&](std::size_t first, std::size_t count) {
      for (std::size_t i = first; i < first + count; ++i) {
        const Stamp stamp = static_cast<Stamp>(stamps_[i]);
        if (age_us(now, stamp) > kLongAgo_us)
          stamps_[i] = static_cast<std::int32_t>(long_before(now));
      }
    });
  }

 private:
  std::size_t stride_;
  std::vector<std::int32_t> stamps_;  // a border of one pixel lies around the frame
  Scrubber scrubber_;
};

}  // namespace asap::fast
