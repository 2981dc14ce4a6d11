// Trial: everything that one seed stands for: its run with faults and, where recovery can be
// judged, its twin without them. Single-threaded; the same seed gives the same trial, byte for
// byte.
#pragma once

#include <cstdint>
#include <limits>
#include <string>

namespace asap::simulation {

inline constexpr unsigned kAllFaults = ~0U;
inline constexpr std::uint64_t kToTheEnd = std::numeric_limits<std::uint64_t>::max();

struct TrialConfig {
  std::uint64_t seed = 0;
  unsigned faults = kAllFaults;     // bit i: fault i may happen
  std::uint64_t until = kToTheEnd;  // steps
  bool fingerprint = false;
  bool live = false;  // a pipeline on a machine of virtual time, else its parts
};

struct TrialResult {
  std::uint64_t seed = 0;
  bool failed = false;
  int law = 0;
  bool judged = false;  // whether the loop has recovered
  std::uint64_t events = 0;
  std::uint64_t packages = 0;
  std::uint64_t steps = 0;
  std::string fingerprint{};
  std::string report{};  // of a failure: seed, configuration, check, step, last steps
};

TrialResult run_trial(const TrialConfig& config);

// The setup and the faults of a trial, for the eye.
std::string describe(const TrialConfig& config);

}  // namespace asap::simulation
