// What the system says about this process.
#pragma once

#include <chrono>
#include <cstddef>

namespace asap::soak {

using Steady = std::chrono::steady_clock;

inline Steady::duration for_seconds(double seconds) {
  return std::chrono::duration_cast<Steady::duration>(std::chrono::duration<double>(seconds));
}
inline double seconds_since(Steady::time_point start) {
  return std::chrono::duration<double>(Steady::now() - start).count();
}

double thread_cpu_s() noexcept;   // processor time of this thread
double process_cpu_s() noexcept;  // of all
double resident_mib();
std::size_t threads();

// Resident memory of a run, of which the first minute, or quarter, is its warming up.
class MemoryWatch {
 public:
  explicit MemoryWatch(double seconds);

  void look();  // every now and then

  double resident() const noexcept { return last_mib_; }
  double growth() const noexcept { return last_mib_ - warm_mib_; }

 private:
  Steady::time_point warm_;
  double warm_mib_ = 0;
  double last_mib_ = 0;
};

}  // namespace asap::soak
