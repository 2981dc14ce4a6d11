// ContrastPixel: the sensor model of one pixel: it remembers a reference level of log brightness
// and fires when the brightness is a threshold above or below. A change moves the reference even
// within the refractory time, in which the pixel is blind. Any one thread; O(changes) per step, no
// allocation.
#pragma once

#include <cstdint>
#include <optional>

namespace asap {

class ContrastPixel {
 public:
  static constexpr std::int64_t kRefractory_us = 300;

  struct Change {
    std::int32_t offset_us;  // after the start of the step, truncated
    bool on;
    friend bool operator==(const Change&, const Change&) = default;
  };

  ContrastPixel() = default;
  // Thresholds above 0; the brightness starts at `level`.
  ContrastPixel(double on, double off, double level, double reference) noexcept
      : on_(on), off_(off), level_(level), reference_(reference) {}

  // Brightness goes linearly to `level` in the step [start_us, start_us + step_us), which is no
  // longer than the refractory time: there is one event at most.
  std::optional<Change> move_to(double level, std::int64_t start_us, std::int32_t step_us) noexcept;

 private:
  double on_ = 0.25;
  double off_ = 0.25;
  double level_ = 0.0;
  double reference_ = 0.0;
  std::int64_t blind_until_us_ = INT64_MIN;
};

}  // namespace asap
