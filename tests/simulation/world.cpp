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

}  // namespace asap::simulation
