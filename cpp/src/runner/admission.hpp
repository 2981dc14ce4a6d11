// Admission: a filter on arrival, in front of the ring. It exists for the rivals of the benchmark
// that thin the stream before they know what waits (study/); the simulator asks it, no product
// does. Asked in virtual time every period_ns; one thread.
#pragma once

#include <cstddef>
#include <cstdint>

namespace asap {

// What has happened since it was last asked.
struct Arrivals {
  std::int64_t now_ns;
  std::size_t arrived;     // raw events, before the filter
  std::size_t waiting;     // in the ring, now
  std::int64_t oldest_ns;  // time of the oldest waiting event; now_ns if there is none
};

class Admission {
 public:
  virtual ~Admission() = default;

  // Kept fraction of what arrives until it is asked again.
  virtual double gamma(const Arrivals& arrivals) noexcept = 0;
  // How often it is asked, > 0.
  virtual std::int64_t period_ns() const noexcept = 0;
};

}  // namespace asap
