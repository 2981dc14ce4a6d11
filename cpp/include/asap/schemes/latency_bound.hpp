// Checks of the parameters that the schemes with a latency bound of their own share.
#pragma once

#include <cstdint>

namespace asap {

// The bound in ns. Throws std::invalid_argument for a value out of range.
std::int64_t checked_latency_ns(double latency_ms);

// The knee factor K: packages longer than K alpha gain little throughput. 0 = no knee.
double checked_knee(double knee);

}  // namespace asap
