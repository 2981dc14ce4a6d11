#include "measure.hpp"

#include <algorithm>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace asap::soak {
namespace {

double seconds_of(clockid_t clock) noexcept {
  timespec time{};
  clock_gettime(clock, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace

double thread_cpu_s() noexcept { return seconds_of(CLOCK_THREAD_CPUTIME_ID); }
double process_cpu_s() noexcept { return seconds_of(CLOCK_PROCESS_CPUTIME_ID); }

double resident_mib() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    if (word != "VmRSS:") continue;
    double kib = 0;
    status >> kib;
    return kib / 1024;
  }
  return 0;
}

std::size_t threads() {
  const std::filesystem::directory_iterator tasks("/proc/self/task");
  return static_cast<std::size_t>(std::distance(begin(tasks), end(tasks)));
}

MemoryWatch::MemoryWatch(double seconds)
    : warm_(Steady::now() + for_seconds(std::min(60.0, seconds / 4))) {}

void MemoryWatch::look() {
  last_mib_ = resident_mib();
  if (Steady::now() < warm_) warm_mib_ = last_mib_;
  if (warm_mib_ == 0) warm_mib_ = last_mib_;
}

}  // namespace asap::soak
