// What a scheduler that knows every arrival can do at best: the smallest latency without a loss,
// and the most events within a latency. Both pay for whole packages, unlike the fluid bound of
// Oracle. Offline: they allocate. Source: notebooks/theory.md, section 9.
#pragma once

#include <cstdint>

#include "asap/core/event.hpp"
#include "asap/runner/simulator.hpp"

namespace asap::inline v0_1 {

// The smallest possible maximum latency of a window when nothing is dropped: the least L for which
// packages exist that finish every event within L of its stamp. Found by bisection; a dynamic
// programme over the boundaries between packages decides one L. The earliest end at each boundary
// is enough, because a server that is free earlier is never worse. O(bins x L / bin) per L tried.
//
// Events in order of time, from an idle algorithm to an empty queue; run time begins at the whole
// second before the first timestamp, as in a run of this window alone. Packages begin and end where
// timestamps fall into different bins of bin_us: the smallest bins (1 us) separate all different
// timestamps, 0 even the events of one timestamp; wider ones are faster and the answer is a little
// above. The cost must be free of noise; drift and outages are foreseen. 0 for no events;
// nanoseconds.
std::int64_t clairvoyant_latency_ns(EventSpan events, const LinearCost& cost, double bin_us = 10.0);

// EC(L), the largest number of events that any scheduler can finish within L of their stamps. A
// package is a block of neighbouring events: to exchange an event for a younger one never hurts.
// O(events x (events per L)^2), mostly far less.
//
// Events in order of time; a timestamp that goes back counts as the one before it. With noise the
// mean cost counts; an event that ends at the bound is in time. Throws std::invalid_argument for a
// cost with drift or outages, and where it may take more than a minute, with the number of events
// that fits.
std::uint64_t exact_clairvoyant(EventSpan events, const LinearCost& cost, double latency_us);

}  // namespace asap::inline v0_1
