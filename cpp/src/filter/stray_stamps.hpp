// Stray timestamps: a few events of a recording whose time is wrong while that of the events around
// them is right, as after a flipped bit. The validator cannot tell: a timestamp that is ahead makes
// all that follow look late until the time has caught up, and one that is far behind looks like a
// reset of the clock. A recording can be looked ahead in, so that the few are dropped and not the
// many.
//
// One thread. O(n) per chunk, only where the validator met a back-step; allocates there.
#pragma once

#include <cstddef>
#include <vector>

#include "asap/core/event.hpp"
#include "asap/filter/validator.hpp"

namespace asap::inline v0_1 {

// Indices of the stray ones among events that come next to `validator`. At most kMaxStray in a row
// are stray: a word of Prophesee's that states the time counts for about 400 events.
inline constexpr std::size_t kMaxStray = 1024;
std::vector<std::size_t> stray_stamps(const Validator& validator, EventSpan events);

// What passed the validator, in order; `kept` is empty where that is all of the events as they are.
struct Checked {
  bool untouched = true;
  std::vector<Event> kept;
  std::size_t stray = 0;  // events that the validator has not seen
};
Checked check_all(Validator& validator, EventSpan events);

// For a chunk of a recording: without those that are stray.
Checked check_recorded(Validator& validator, EventSpan events);

}  // namespace asap::inline v0_1
