#include "world.hpp"

namespace asap::simulation {

bool World::happens(FaultKind kind) noexcept {
  for (std::size_t i = 0; i < faults.size(); ++i) {
    const Fault& fault = faults[i];
    if (fault.kind != kind || over[i] || stream.position() < fault.begin) continue;
    over[i] = true;
    return true;
  }
  return false;
}

std::int64_t World::lag_ns() noexcept {
  if (longest_lag_ns == 0 || draw.chance(0.7)) return 0;
  return draw.between(0, longest_lag_ns);
}

}  // namespace asap::simulation
