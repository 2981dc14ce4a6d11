// exact_clairvoyant: EC(L), the largest number of events that any scheduler can finish within L of
// their stamps, even one that knows every arrival. Unlike the fluid bound of Oracle it pays for
// whole packages, so it is reached. A package is a block of neighbouring events: to exchange an
// event for a younger one never hurts. Offline: allocates; O(events x (events per L)^2), mostly far
// less. Source: notebooks/theory.md, section 9.
#pragma once

#include <cstdint>

#include "asap/core/event.hpp"
#include "asap/runner/linear_cost.hpp"

namespace asap {

inline constexpr double kMostExactSteps = 8e10;  // a minute at most

// Events in order of time; a stamp that goes back counts as the one before it. With noise the mean
// cost counts; an event that ends at the bound is in time. Throws std::invalid_argument for a cost
// with drift or outages, and where it may take more than most_steps, with the number of events that
// fits.
std::uint64_t exact_clairvoyant(EventSpan events, const LinearCost& cost, double latency_us,
                                double most_steps = kMostExactSteps);

}  // namespace asap
