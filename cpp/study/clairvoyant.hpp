// The smallest possible maximum latency of a window when nothing is dropped and the future is
// known: the least L for which packages exist that finish every event within L of its stamp. Found
// by bisection; a dynamic programme over the boundaries between packages decides one L. The
// earliest end at each boundary is enough, because a server that is free earlier is never worse.
// Offline: allocates; O(bins x L / bin) per L tried. Source: notebooks/theory.md, section 9.
#pragma once

#include <cstdint>

#include "asap/core/event.hpp"
#include "asap/runner/linear_cost.hpp"

namespace asap {

// Events in order of time, from an idle algorithm to an empty queue; run time begins at the whole
// second before the first stamp, as in a run of this window alone. Packages begin and end where
// stamps fall into different bins of bin_us: the smallest bins (1 us) separate all different
// stamps, 0 even the events of one stamp; wider ones are faster and the answer is a little above.
// The cost must be free of noise; drift and outages are foreseen. 0 for no events; nanoseconds.
std::int64_t clairvoyant_latency_ns(EventSpan events, const LinearCost& cost, double bin_us = 10.0);

}  // namespace asap
