// Checks of the parameters that the schemes with a latency bound of their own share.
#pragma once

#include <cstdint>

namespace asap {

// The bound in ns. Throws std::invalid_argument for a value out of range.
std::int64_t checked_latency_ns(double latency_ms);

// The bound in force in ms: the configured number itself, while that is the one.
double latency_ms(std::int64_t bound_ns, double configured_ms) noexcept;

// The knee factor K: packages longer than K alpha gain little throughput. 0 = no knee.
double checked_knee(double knee);

}  // namespace asap
