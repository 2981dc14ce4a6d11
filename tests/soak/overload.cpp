// Five times what the algorithm can do: under the latency bound, and under a scheme that knows no
// gamma, where the ring thins. Overflow has to end within a second, the latency stays bounded.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "asap/runner/pipeline.hpp"
#include "asap/schemes/deadline.hpp"
#include "asap/schemes/fixed.hpp"
#include "camera.hpp"
#include "measure.hpp"
#include "parts.hpp"
#include "study/realtime.hpp"

namespace asap::soak {
namespace {

using namespace std::chrono_literals;

constexpr double kAlpha_us = 100;
constexpr double kBeta_ns = 1000;
constexpr double kRate = 5e6;

// When packages ended, and how many events had been delivered by then.
struct Progress {
  std::vector<std::pair<Steady::time_point, std::uint64_t>> ends;

  void note(std::size_t size) {
    ends.emplace_back(Steady::now(), (ends.empty() ? 0 : ends.back().second) + size);
  }
  // The longest that the algorithm has taken for so many events, whatever kept it.
  double longest_ms(std::uint64_t events) const {
    Steady::duration longest{};
    for (std::size_t from = 0, to = 0; to < ends.size(); ++to) {
      while (ends[to].second - ends[from].second >= events) {
        longest = std::max(longest, ends[to].first - ends[from].first);
        ++from;
      }
    }
    return std::chrono::duration<double, std::milli>(longest).count();
  }
};

void overloaded(const std::string& name, Scheme& scheme, const RunConfig& config, double seconds,
                std::uint64_t seed) {
  BusyWait work({.alpha_us = kAlpha_us, .beta_ns = kBeta_ns});
  Progress progress;
  progress.ends.resize(static_cast<std::size_t>(seconds * 2e3));  // memory that is there already
  progress.ends.clear();
  MemoryWatch memory(seconds);
  Camera camera(static_cast<std::size_t>(kRate * 1e-3), seed);
  Pipeline pipeline(scheme, config);
  std::thread consumer([&] {
    pipeline.run([&](const Package& package) {
      if (!package.continues) work.begin();
      work.process(package.events);
      progress.note(package.events.size());
    });
  });
  Camera::Pushed pushed;
  std::atomic<bool> done = false;
  std::thread producer([&] {
    pushed = camera.push_paced(pipeline, kRate, seconds);
    done = true;
  });
  std::uint64_t settled_overflow = 0;  // by the end of the first second
  for (const auto start = Steady::now(); !done;) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    memory.look();
    if (seconds_since(start) <= 1) settled_overflow = pipeline.ledger().overflow;
  }
  producer.join();
  pipeline.stop(false);
  consumer.join();

  const PipelineStats stats = pipeline.stats();
  const Ledger& ledger = stats.ledger;
  // Without a bound of the scheme the ring is the queue: what it holds, and the package in work.
  const double bound_ms = scheme.latency_bound_ns() > 0
                              ? static_cast<double>(scheme.latency_bound_ns()) * 1e-6
                              : progress.longest_ms(config.capacity + 2 * stats.packages.size_max);
  figure(name + "_events", pushed.events);
  figure(name + "_wrong", !(ledger.balanced() && ledger.received == pushed.events));
  figure(name + "_overflow", ledger.overflow - settled_overflow);
  figure(name + "_kept",
         static_cast<double>(ledger.delivered) / static_cast<double>(ledger.received));
  figure(name + "_p99_of_bound", stats.latency.quantile_ns(0.99) * 1e-6 / bound_ms);
  figure(name + "_max_of_bound", static_cast<double>(stats.latency.max_ns()) * 1e-6 / bound_ms);
  figure(name + "_late_ms", 1e3 * pushed.late_s);
  figure(name + "_memory_growth_mib", memory.growth());
}

}  // namespace

void overload(double seconds, std::uint64_t seed) {
  Deadline deadline({.latency = 10ms});
  overloaded("deadline", deadline, {}, seconds / 2, seed);
  figure("deadline_alpha_us", deadline.alpha_ns() * 1e-3);
  FixedSize fixed_size({.size = 1000});
  const RunConfig config{
      .capacity = 262'144, .execution = Execution::whole, .when_full = WhenFull::thin};
  overloaded("thin", fixed_size, config, seconds / 2, seed);
}

}  // namespace asap::soak
