// Search: many seeds on several threads, each seed in one of them; and what to do with one that
// fails: the fewest faults with which it still does, and how to see it again.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "trial.hpp"

namespace asap::simulation {

struct SearchConfig {
  std::uint64_t first = 0;
  std::uint64_t last = 0;
  unsigned jobs = 1;
  bool live = false;
  std::size_t max_failures = 10;  // then the search ends
};

struct SearchResult {
  std::uint64_t seeds = 0;
  std::uint64_t events = 0;
  std::uint64_t packages = 0;
  std::uint64_t steps = 0;
  std::uint64_t judged = 0;
  std::vector<std::uint64_t> failures;  // seeds
};

SearchResult search(const SearchConfig& config);

// Drops one fault after the other while the same law is broken. The failing trial and its report.
struct Minimal {
  TrialConfig config;
  TrialResult result;
};
Minimal minimise(const TrialConfig& config);

// Seed, configuration, faults, violated check, last steps, and the command that shows them again.
std::string report(const Minimal& minimal);

}  // namespace asap::simulation
