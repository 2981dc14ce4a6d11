// The velocity of a cluster by regression of x and y on t over its chain of live events: from the
// moments, O(1); where their sums of squared times overflow, in windows of minutes, by a walk over
// the chain, O(its events). Not per event: at the read-out. No allocation.
#pragma once

#include "algorithms/event_window.hpp"
#include "algorithms/window_moments.hpp"

namespace asap {

// px/us; 0 if all stamps are equal. `newest` is the chain's newest event, `moments` are the
// chain's.
Vector2 chain_velocity(const EventWindow& window, EventWindow::Position newest,
                       const WindowMoments& moments) noexcept;

}  // namespace asap
