// Silence: what it costs to wait, and how soon the algorithm starts when an event breaks it.
#include <algorithm>
#include <atomic>
#include <thread>
#include <vector>

#include "asap/runner/pipeline.hpp"
#include "camera.hpp"
#include "core/random.hpp"
#include "measure.hpp"
#include "parts.hpp"

namespace asap::soak {
namespace {

using namespace std::chrono_literals;

double quantile(const std::vector<double>& sorted, double q) {
  return sorted.empty()
             ? 0
             : sorted[static_cast<std::size_t>(q * static_cast<double>(sorted.size() - 1))];
}

// Events that have been waiting for too long to reach the algorithm.
std::uint64_t dropped_of(const Pipeline& pipeline) {
  const Ledger ledger = pipeline.ledger();
  return ledger.stale + ledger.discarded;
}

}  // namespace

void idle(double seconds, std::uint64_t seed) {
  const CounterRandom random(seed);
  Camera camera(1, seed);
  std::atomic<Steady::time_point> started{};
  Pipeline pipeline({.latency = 10ms}, [&](EventSpan) { started = Steady::now(); });
  pipeline.push(camera.packet(1, 1));  // the clock of the run has begun
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  {
    const double cpu_s = process_cpu_s();
    const auto start = Steady::now();
    std::this_thread::sleep_for(for_seconds(seconds / 3));
    figure("idle_cpu_percent", 100 * (process_cpu_s() - cpu_s) / seconds_since(start));
  }
  std::vector<double> wake_ups_us;
  std::uint64_t lost = 0;
  std::uint64_t dropped = dropped_of(pipeline);
  const auto start = Steady::now();
  for (std::uint64_t i = 0; seconds_since(start) < seconds * 2 / 3; ++i) {
    std::this_thread::sleep_for(std::chrono::microseconds(5000 + random(i) % 2000));
    const auto pushed = Steady::now();
    pipeline.push(camera.packet(1, 1));
    while (started.load() < pushed && seconds_since(pushed) < 20) {
      // Who wakes too late finds an event that is too old, which is not a lost wake-up.
      if (seconds_since(pushed) > 0.01 && dropped_of(pipeline) > dropped) break;
      std::this_thread::yield();
    }
    const auto came = started.load();
    const std::uint64_t dropped_now = dropped_of(pipeline);
    if (came >= pushed) {
      wake_ups_us.push_back(std::chrono::duration<double, std::micro>(came - pushed).count());
    } else if (dropped_now > dropped) {
      wake_ups_us.push_back(1e6 * seconds_since(pushed));
    } else {
      ++lost;
    }
    dropped = dropped_now;
  }
  std::sort(wake_ups_us.begin(), wake_ups_us.end());
  figure("wake_ups", wake_ups_us.size());
  figure("wake_ups_lost", lost);
  figure("wake_up_p50_us", quantile(wake_ups_us, 0.5));
  figure("wake_up_p99_us", quantile(wake_ups_us, 0.99));
  figure("wake_up_max_us", quantile(wake_ups_us, 1.0));
}

}  // namespace asap::soak
