// The machine's own scheduling jitter: a thread that does nothing but look at the clock is not
// always running, and what it misses no scheme can give back. Real-time figures are read beside it.
#pragma once

#include <chrono>

#include "asap/telemetry/latency_histogram.hpp"

namespace asap {

// Times between two looks at the steady clock, over a stretch of time, on the caller's thread.
LatencyHistogram scheduling_jitter(std::chrono::nanoseconds duration);

}  // namespace asap
