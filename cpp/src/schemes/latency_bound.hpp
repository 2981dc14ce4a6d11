// The check of the parameter latency_ms, for every scheme with a latency bound of its own.
#pragma once

#include <cstdint>

namespace asap {

// The bound in ns. Throws std::invalid_argument for a value out of range.
std::int64_t checked_latency_ns(double latency_ms);

}  // namespace asap
