// Draw: the choices of one seed, one after the other. Integer arithmetic, + - * / only: the same
// choices with every compiler. Two purposes of one seed give unrelated draws, so that one of them
// may be left out without a change of the other.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "core/random.hpp"

namespace asap::simulation {

class Draw {
 public:
  Draw(std::uint64_t seed, std::uint64_t purpose) noexcept
      : random_(seed ^ detail::mix(purpose + 1)) {}

  std::uint64_t bits() noexcept { return random_(next_++); }
  double uniform() noexcept { return random_.uniform(next_++); }
  bool chance(double probability) noexcept { return uniform() < probability; }

  // Of [0, count), count >= 1.
  std::size_t below(std::size_t count) noexcept { return static_cast<std::size_t>(bits() % count); }

  // Of [low, high].
  std::int64_t between(std::int64_t low, std::int64_t high) noexcept {
    return low + static_cast<std::int64_t>(bits() % static_cast<std::uint64_t>(high - low + 1));
  }

  // Of [low, high], every octave as likely as any other.
  double octaves(double low, double high) noexcept {
    std::size_t count = 1;
    for (double top = 2 * low; 2 * top <= high; top *= 2) ++count;
    double value = low * (1.0 + uniform());
    for (std::size_t i = below(count); i > 0; --i) value *= 2;
    return std::min(value, high);
  }

 private:
  CounterRandom random_;
  std::uint64_t next_ = 0;
};

}  // namespace asap::simulation
