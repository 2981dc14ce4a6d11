// Stops a pipeline at a random moment, in a random state, from outside or inside, or by an
// exception of its algorithm: it must end soon, add up, leave no thread behind and begin anew.
#include <algorithm>
#include <atomic>
#include <optional>
#include <stdexcept>
#include <thread>

#include "asap/runner/pipeline.hpp"
#include "camera.hpp"
#include "core/random.hpp"
#include "measure.hpp"
#include "parts.hpp"

namespace asap::soak {
namespace {

using namespace std::chrono_literals;

struct Totals {
  std::uint64_t trials = 0;
  std::uint64_t thrown = 0;
  std::uint64_t wrong = 0;
  std::uint64_t threads_left = 0;
  double longest_ms = 0;
};

struct Thrown : std::domain_error {
  Thrown() : std::domain_error("of the algorithm") {}
};

void wait(std::uint64_t us) {
  const auto start = Steady::now();
  if (us > 300) std::this_thread::sleep_for(std::chrono::microseconds(us / 2));
  while (Steady::now() - start < std::chrono::microseconds(us)) {
  }
}

// A thread that has been joined is gone from the table soon after, not at once.
bool threads_become(std::size_t count) {
  for (const auto start = Steady::now(); seconds_since(start) < 20;) {
    if (threads() == count) return true;
    std::this_thread::yield();
  }
  return false;
}

void one_trial(std::uint64_t seed, Totals& totals) {
  const CounterRandom random(seed);
  const std::size_t threads_before = threads();
  const std::uint64_t throws_at = random(0) % 3 == 0 ? 1 + random(1) % 5 : 0;
  const std::uint64_t stops_at = random(0) % 3 == 1 ? 1 + random(1) % 5 : 0;
  const std::uint64_t work_us = random(2) % 4 == 0 ? random(3) % 2000 : 0;
  const bool drain = random(4) % 2 == 0;
  std::optional<Pipeline> pipeline;
  std::uint64_t calls = 0;
  std::uint64_t seen = 0;
  bool rough = true;
  const auto algorithm = [&](EventSpan events) {
    if (rough && ++calls == throws_at) throw Thrown();
    if (rough && calls == stops_at) pipeline->stop(drain);
    if (rough) wait(work_us);
    seen += events.size();
  };
  pipeline.emplace(RunConfig{.latency = 1000us,
                             .capacity = 1 + random(5) % 5000,
                             .when_full = static_cast<WhenFull>(random(6) % 4)},
                   algorithm);
  std::uint64_t sent = 0;
  std::thread producer;
  if (random(7) % 8 != 0) {
    producer = std::thread([&] {
      Camera camera(1000, seed);
      for (std::uint64_t i = 0;; ++i) {
        const std::size_t size = 1 + random(100 + i) % 1000;
        if (!pipeline->push(camera.packet(size, 10))) return;
        sent += size;
        if (random(8) % 2 == 0) wait(random(200 + i) % 200);
      }
    });
  }
  wait(random(9) % 2000);
  if (random(10) % 4 == 0) pipeline->flush();

  const auto begin = Steady::now();
  pipeline->stop(drain);
  bool thrown = false;
  try {
    pipeline->join();
  } catch (const Thrown&) {
    thrown = true;
  }
  if (producer.joinable()) producer.join();
  totals.longest_ms = std::max(totals.longest_ms, 1e3 * seconds_since(begin));
  pipeline->stop();
  const Ledger ledger = pipeline->ledger();
  // A part of an anytime package that was thrown out of is seen, but the package stays pending.
  const bool exact = ledger.balanced() && ledger.received == sent &&
                     (thrown ? ledger.delivered <= seen : ledger.delivered == seen) &&
                     thrown == (throws_at > 0 && calls >= throws_at);

  rough = false;
  seen = 0;
  pipeline->start();
  Camera camera(1, seed);
  const bool taken = pipeline->push(camera.packet(1, 1));
  pipeline->stop();
  pipeline->join();
  // On a busy machine the event may be too old by the time its worker runs.
  const Ledger after = pipeline->ledger();
  const bool again = taken && after.balanced() && after.received == 1 && after.delivered == seen &&
                     after.delivered + after.stale == 1;
  pipeline.reset();

  if (!exact || !again) {
    ++totals.wrong;
    std::cerr << "stops: seed " << seed << ": sent " << sent << ", received " << ledger.received
              << ", delivered " << ledger.delivered << ", pending " << ledger.pending << ", thrown "
              << thrown << " at " << throws_at << " of " << calls << ", again " << again << '\n';
  }
  ++totals.trials;
  totals.thrown += thrown;
  if (!threads_become(threads_before)) ++totals.threads_left;
}

}  // namespace

void stops(double seconds, std::uint64_t seed) {
  Totals totals;
  for (const auto start = Steady::now(); seconds_since(start) < seconds;) one_trial(seed++, totals);
  figure("stop_trials", totals.trials);
  figure("stop_thrown", totals.thrown);
  figure("stop_wrong", totals.wrong);
  figure("stop_threads_left", totals.threads_left);
  figure("stop_longest_ms", totals.longest_ms);
}

}  // namespace asap::soak
