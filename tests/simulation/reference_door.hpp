// ReferenceDoor: what the validator does, written down event by event from its header.
#pragma once

#include <cstdint>

#include "asap/filter/validator.hpp"

namespace asap::simulation {

class ReferenceDoor {
 public:
  explicit ReferenceDoor(const ValidatorConfig& config) noexcept : config_(config) {}

  // Repairs the event. False: it is rejected.
  bool passes(Event& event) noexcept { return passes(event, {}, true); }

  // The same at a live door, which `next` events of the same push follow: a clock is only set back
  // by stamps that stay there.
  bool passes_live(Event& event, EventSpan next) noexcept {
    return passes(event, next, config_.on_bad == OnBad::raise);
  }

  std::uint64_t received = 0;
  Rejections rejected;
  std::uint64_t resets = 0;

 private:
  bool passes(Event& event, EventSpan next, bool trusts) noexcept {
    ++received;
    if (event.t > kLatestStamp || event.t < -kLatestStamp) return reject(rejected.bad_record);
    const bool clamps = config_.on_bad == OnBad::clamp;
    const int last_x = config_.width == 0 ? 65535 : config_.width - 1;
    const int last_y = config_.height == 0 ? 65535 : config_.height - 1;
    const bool inside = event.x <= last_x && event.y <= last_y;
    if (!inside && !clamps) return reject(rejected.out_of_bounds);

    std::int64_t offset_us = offset_us_;
    std::int64_t t = event.t + offset_us;
    if (any_ && t < last_us_) {
      const std::int64_t back_us = last_us_ - t;
      if (back_us >= 1'000'000) {
        if (!trusts && !stay(next)) {
          ++far_back_;
          return reject(rejected.nonmonotonic);
        }
        t = last_us_ + 1;
        offset_us = t - event.t;
      } else if (clamps || back_us <= config_.reorder_tolerance / std::chrono::microseconds(1)) {
        t = last_us_;
      } else {
        return reject(rejected.nonmonotonic);
      }
    }
    far_back_ = 0;
    if (t > kLatest) return reject(rejected.bad_record);
    resets += offset_us != offset_us_ ? 1U : 0U;
    offset_us_ = offset_us;
    if (event.x > last_x) event.x = static_cast<std::uint16_t>(last_x);
    if (event.y > last_y) event.y = static_cast<std::uint16_t>(last_y);
    event.p = event.p >= 1 ? 1 : 0;
    event.t = last_us_ = t;
    any_ = true;
    return true;
  }

  // Whether 32 in a row are far back: those that were, this one, and those that follow.
  bool stay(EventSpan next) const noexcept {
    std::size_t in_a_row = far_back_ + 1;
    for (const Event& event : next) {
      if (in_a_row >= 32) break;
      const bool is_stamp = event.t <= kLatestStamp && event.t >= -kLatestStamp;
      if (is_stamp && last_us_ - (event.t + offset_us_) < 1'000'000) return false;
      ++in_a_row;
    }
    return in_a_row >= 32;
  }

  static constexpr std::int64_t kLatest = std::int64_t{1} << 52;
  static constexpr std::int64_t kLatestStamp = std::int64_t{3} << 50;  // as it comes

  static bool reject(std::uint64_t& reason) noexcept {
    ++reason;
    return false;
  }

  const ValidatorConfig config_;
  bool any_ = false;
  std::size_t far_back_ = 0;
  std::int64_t last_us_ = 0;
  std::int64_t offset_us_ = 0;
};

}  // namespace asap::simulation
