// Exponential and logarithm in single precision from + - * / alone: the same bits on every
// platform, which the C libraries' do not give. O(1).
#pragma once

#include <algorithm>

namespace asap::fast {

// exp(-u), u >= 0. Relative error below 2e-5 up to u = 12, 1e-3 up to 30.
constexpr float decay(float u) noexcept {
  constexpr float kHalvings = 64;
  const float x = std::min(u, 80.0F) / kHalvings;
  float growth = 1 + x * (1 + x * (0.5F + x * (1.0F / 6 + x * (1.0F / 24 + x / 120))));
  for (int doubling = 0; doubling < 6; ++doubling) growth *= growth;
  return 1 / growth;
}

// ln(y), y >= 0.5. Absolute error below 1e-5 up to 1000.
constexpr float logarithm(float y) noexcept {
  constexpr float kLn2 = 0.69314718F;
  float sum = 0;
  for (; y > 1.5F && sum < 90; y /= 2) sum += kLn2;
  const float z = (y - 1) / (y + 1);
  const float z2 = z * z;
  return sum + 2 * z * (1 + z2 * (1.0F / 3 + z2 * (1.0F / 5 + z2 * (1.0F / 7 + z2 / 9))));
}

// The weight of the newest of the values of a low pass with time constant `tau_s` that has run for
// `age_s`, the last step of dt_s included: at first it is the mean over the age.
constexpr float low_pass_weight(float decayed, float dt_s, float age_s) noexcept {
  return std::max(1 - decayed, dt_s < age_s ? dt_s / age_s : 1.0F);
}

}  // namespace asap::fast
