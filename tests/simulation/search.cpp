#include "search.hpp"

#include <algorithm>
#include <atomic>
#include <mutex>
#include <thread>

#include "faults.hpp"

namespace asap::simulation {

SearchResult search(const SearchConfig& config) {
  SearchResult sum;
  std::mutex mutex;
  std::atomic<std::uint64_t> next{0};
  const std::uint64_t count = config.last - config.first + 1;
  const auto work = [&] {
    for (std::uint64_t i = next++; i < count; i = next++) {
      const TrialResult result = run_trial({.seed = config.first + i, .live = config.live});
      const std::lock_guard lock(mutex);
      ++sum.seeds;
      sum.events += result.events;
      sum.packages += result.packages;
      sum.steps += result.steps;
      sum.judged += result.judged ? 1U : 0U;
      if (!result.failed) continue;
      sum.failures.push_back(result.seed);
      if (sum.failures.size() >= config.max_failures) next = count;
    }
  };
  {
    std::vector<std::jthread> threads;
    for (unsigned i = 1; i < config.jobs; ++i) threads.emplace_back(work);
    work();
  }
  std::sort(sum.failures.begin(), sum.failures.end());
  return sum;
}

Minimal minimise(const TrialConfig& config) {
  Minimal best{config, run_trial(config)};
  best.config.faults &= (1U << kMaxFaults) - 1;
  for (unsigned i = 0; i < kMaxFaults; ++i) {
    TrialConfig fewer = best.config;
    fewer.faults &= ~(1U << i);
    if (fewer.faults == best.config.faults) continue;
    TrialResult result = run_trial(fewer);
    if (result.failed && result.law == best.result.law) best = {fewer, std::move(result)};
  }
  return best;
}

std::string report(const Minimal& minimal) {
  const std::string seed = std::to_string(minimal.config.seed);
  return "seed " + seed + "\n" + minimal.result.report + "  again: simulation --seed " + seed +
         (minimal.config.live ? " --life live" : "") + " --faults " +
         std::to_string(minimal.config.faults) + " --until " +
         std::to_string(minimal.result.steps) + "\n";
}

}  // namespace asap::simulation
