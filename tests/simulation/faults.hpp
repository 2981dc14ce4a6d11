// Faults: what a seed lets go wrong: none to six of the list F1-F20 of the reliability reference,
// those that a simulator can express. Each fault draws its own details, so that one may be dropped
// and the others stay what they are. A fault is in force while the source is between two events.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "setup.hpp"

namespace asap::simulation {

enum class FaultKind {
  slower,       // F1: x2 ... x100
  stall,        // F2: 10 ms, 1 s, some bounds
  odd_cost,     // F3: heavy-tailed, bimodal, 0, a clock that steps back
  exception,    // F4: the consumer throws
  gone,         // F5: the consumer never returns
  rate,         // F6: step, square wave, ramp
  silence,      // F7: and then a burst
  anomalies,    // F8: A1-A9
  reconfigure,  // F9: another scheme, bound and ring at a restart
  restart,      // F10: the source ends, and starts again
  odd_ring,     // F11: 1, 2, 2^k +- 1
  stop,         // F12: drained or not, before the start, twice, from inside the algorithm
  extreme,      // F16: seeds, a hostile scheme
};
inline constexpr std::size_t kFaultKinds = 13;

struct Fault {
  FaultKind kind;
  std::size_t begin;  // events of the source
  std::size_t end;
  std::uint64_t key;  // of its details

  bool acts(std::size_t event) const noexcept { return event >= begin && event < end; }
  Draw draw() const noexcept { return Draw(key, 3); }
};

inline constexpr std::size_t kMaxFaults = 6;

// Bit i of the mask permits fault i.
std::vector<Fault> draw_faults(const Setup& setup, unsigned mask);

// The faults that are a configuration.
void configure(Setup& setup, const std::vector<Fault>& faults);
// What a restart changes.
void reconfigure(Setup& setup, const Fault& fault);

std::string text(const std::vector<Fault>& faults);

}  // namespace asap::simulation
