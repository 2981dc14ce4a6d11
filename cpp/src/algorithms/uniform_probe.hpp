// UniformProbe: the sampler of the published rule. Draws one live event of a cluster, uniformly and
// with replacement, from a sequential stream of core/random.hpp: the same seed and the same events
// give the same draws on every platform. O(1), no allocation.
// Another sampler may use the draw's name (event, cluster, number) instead of a stream of its own.
#pragma once

#include <cstdint>

#include "asap/core/random.hpp"

namespace asap {

// Names one draw, whatever the order in which the draws of an event are made.
struct ProbeDraw {
  std::uint64_t event;    // number of the event in the stream
  std::uint64_t cluster;  // creation number of the cluster
  std::uint64_t probe;    // 0 .. kappa - 1
};

class UniformProbe {
 public:
  explicit UniformProbe(std::uint64_t seed) noexcept : random_(seed) {}

  // Returns member(i) for an i in [0, count), count < 2^32.
  template <class Member>
  auto operator()(const ProbeDraw&, std::uint64_t count, Member&& member) noexcept {
    return member((random_(draws_++) >> 32) * count >> 32);
  }

  void clear() noexcept { draws_ = 0; }

 private:
  CounterRandom random_;
  std::uint64_t draws_ = 0;
};

}  // namespace asap
