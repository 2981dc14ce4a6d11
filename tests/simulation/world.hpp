// World: what one life hands to the next: the camera, the algorithm's cost, the faults to come.
#pragma once

#include <cstdint>
#include <vector>

#include "consumer_cost.hpp"
#include "draw.hpp"
#include "faults.hpp"
#include "journal.hpp"
#include "shadow.hpp"
#include "stream.hpp"

namespace asap::simulation {

struct World {
  const std::vector<Fault>& faults;
  Stream& stream;
  ConsumerCost& cost;
  Draw& draw;
  Journal& journal;
  Tally& tally;
  std::int64_t longest_lag_ns;
  std::vector<bool> over{};  // faults that have happened: stops, exceptions, restarts

  // Whether one of this kind happens now; each does once.
  bool happens(FaultKind kind) noexcept;

  // By how much a thread is held up between two steps: mostly not at all.
  std::int64_t lag_ns() noexcept;
};

}  // namespace asap::simulation
