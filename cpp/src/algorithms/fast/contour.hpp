// Contour: the outline of an object as a radius per direction, in 16 bins, and the variance of the
// events about it. The edges of an object fire unevenly, so the plain mean of its events wobbles;
// the radial residual, distance minus radius of that direction, does not. The sides of its box are
// pushed outwards by the outermost events. One thread. O(1), no allocation.
// Source: own design.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "algorithms/fast/constants.hpp"
#include "algorithms/fast/time.hpp"

namespace asap::inline v0_1::fast {

inline constexpr std::size_t kContourBins = 16;

struct Box {
  float left;  // px
  float top;
  float right;
  float bottom;

  float width() const noexcept { return right - left; }
  float height() const noexcept { return bottom - top; }

  Box moved(float dx, float dy) const noexcept {
    return {left + dx, top + dy, right + dx, bottom + dy};
  }
};

// The box around both.
inline Box united(const Box& a, const Box& b) noexcept {
  return {std::min(a.left, b.left), std::min(a.top, b.top), std::max(a.right, b.right),
          std::max(a.bottom, b.bottom)};
}

struct alignas(64) Contour {
  static constexpr float kInitialVariance_px2 = 4;
  static constexpr float kVarianceMemory = 64;  // events

  std::array<float, kContourBins> radius{};
  Box sides{};  // from the mean
  std::array<std::uint8_t, kContourBins> count{};
  float variance = kInitialVariance_px2;  // px^2, of the residuals
  // px, mean of the displacements from the centre, those of OFF events negative.
  float dipole_x = 0;
  float dipole_y = 0;
  float polarity = 0;          // mean, OFF = -1, ON = 1
  float average_polarity = 0;  // of the samples of `polarity`, and of its square
  float average_polarity2 = 0;
  float least_gain = 1.0F / kMeanEvents;  // least weight of an event in the mean
  float outline_weight = 0;               // on the residual, against the track's mean_weight

  // Sets the memory of the mean.
  void set_memory(std::uint32_t events) noexcept { least_gain = 1 / static_cast<float>(events); }

  bool known(std::size_t bin) const noexcept { return count[bin] >= kKnownContourEvents; }

  bool holds(float dx, float dy) const noexcept {
    return dx >= sides.left && dx <= sides.right && dy >= sides.top && dy <= sides.bottom;
  }

  // Pushes the sides towards an event beyond them, by `growth` px at most. Rare, so not inline.
  void push_sides(float dx, float dy, float growth) noexcept;

  // Moves the sides inwards for so many events: one in a hundred or less lies beyond a side.
  void shrink_sides(std::uint32_t events) noexcept {
    constexpr float kPerEvent = 0.001F;
    constexpr float kPast_px = 10;  // where they go, on the other side of the mean
    const float share = 1 - decay(kPerEvent * static_cast<float>(events));
    sides.left += share * (kPast_px - sides.left);
    sides.top += share * (kPast_px - sides.top);
    sides.right -= share * (kPast_px + sides.right);
    sides.bottom -= share * (kPast_px + sides.bottom);
  }

  void learn_polarity(bool on, float dx, float dy, float gain) noexcept {
    const auto sign = static_cast<float>(2 * on - 1);
    dipole_x += gain * (sign * dx - dipole_x);
    dipole_y += gain * (sign * dy - dipole_y);
    polarity += gain * (sign - polarity);
  }

  // For every sixteenth event.
  void sample_polarity() noexcept {
    constexpr float kShare = 1.0F / 64;
    average_polarity += kShare * (polarity - average_polarity);
    average_polarity2 += kShare * (polarity * polarity - average_polarity2);
  }

  // Whether the events have one polarity for a while and then the other, as those of a lamp have,
  // which is lit and goes out as a whole. The edges of a thing that moves fire at the same time.
  // `before`: whether they did so.
  bool flickers(bool before) const noexcept {
    constexpr float kBegins = 0.4F;  // variance; 1 for a large lamp
    constexpr float kGoesOn = 0.3F;  // 0.36 where nine tenths of the events are ON
    return average_polarity2 - average_polarity * average_polarity > (before ? kGoesOn : kBegins);
  }

  static float clip(float residual) noexcept {
    return std::max(-kContourClip_px, std::min(residual, kContourClip_px));
  }

  // Distance of an event from the outline, positive outside.
  float residual(std::size_t bin, float distance) const noexcept { return distance - radius[bin]; }

  void learn(std::size_t bin, float distance) noexcept {
    const float outwards = residual(bin, distance);
    const float clipped = clip(outwards);
    if (known(bin)) variance += (clipped * clipped - variance) / kVarianceMemory;
    count[bin] = std::min<std::uint8_t>(kContourEvents, static_cast<std::uint8_t>(count[bin] + 1));
    radius[bin] += outwards / static_cast<float>(count[bin]);
  }

  void forget_radius() noexcept { count.fill(0); }
};

// The direction bin of a displacement, by table: rounded to px and clamped to +-32.
class DirectionTable {
 public:
  DirectionTable();

  // `distance`: length of the displacement.
  std::size_t bin(float dx, float dy, float distance) const noexcept {
    constexpr float kLimit = kReach;
    if (distance > kLimit - 1) [[unlikely]] {
      dx = std::clamp(dx, -kLimit, kLimit - 1);
      dy = std::clamp(dy, -kLimit, kLimit - 1);
    }
    return bins_[index(dy) * kSide + index(dx)];
  }

 private:
  static constexpr int kReach = 32;
  static constexpr std::size_t kSide = 2 * kReach;

  static std::size_t index(float d) noexcept {
    return static_cast<std::size_t>(static_cast<std::int64_t>(d + (kReach + 0.5F)));
  }

  std::array<std::uint8_t, kSide * kSide> bins_;
};

}  // namespace asap::inline v0_1::fast
