// Rounds of a quarter of a second, each with another ring, rule, scheme and algorithm, pushes and
// packages of 1 to 10^6 events with bad ones among them, and up to three runs of the pipeline: what
// was sent and what came out, counted here, against the ledger. Snapshots meanwhile must balance
// and never go back. Every stop ends soon and leaves no thread behind.
#include <algorithm>
#include <atomic>
#include <memory>
#include <thread>

#include "asap/runner/pipeline.hpp"
#include "asap/schemes/asap2020.hpp"
#include "asap/schemes/deadline.hpp"
#include "asap/schemes/fixed.hpp"
#include "asap/schemes/greedy.hpp"
#include "camera.hpp"
#include "core/random.hpp"
#include "measure.hpp"
#include "parts.hpp"
#include "study/realtime.hpp"
#include "support/allocation_counter.hpp"

namespace asap::soak {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t kLargestPacket = 1'000'000;
constexpr double kRoundSeconds = 0.25;

// 1 to kLargestPacket, of any order of magnitude.
std::size_t any_size(std::uint64_t bits) { return 1 + (bits >> 8) % (kLargestPacket >> bits % 20); }

struct Totals {
  std::uint64_t runs = 0;
  std::uint64_t events = 0;
  std::uint64_t delivered = 0;
  std::uint64_t snapshots = 0;
  std::uint64_t wrong = 0;
  std::uint64_t allocations = 0;
  std::uint64_t threads_left = 0;
  double longest_stop_ms = 0;
};

std::unique_ptr<Scheme> any_scheme(std::uint64_t choice) {
  switch (choice % 5) {
    case 0:
      return std::make_unique<Deadline>(DeadlineConfig{.latency = 2ms});
    case 1:
      return std::make_unique<FixedSize>(FixedSizeConfig{.size = any_size(choice / 5)});
    case 2:
      return std::make_unique<FixedTime>(FixedTimeConfig{.period = 1ms});
    case 3:
      return std::make_unique<Asap2020>();
    default:
      return std::make_unique<Greedy>();
  }
}

RunConfig any_config(const CounterRandom& random) {
  constexpr std::size_t kCapacities[] = {1, 2, 7, 64, 1000, 65'536, 1'000'003};
  return {.latency = 2000us,
          .capacity = kCapacities[random(1) % std::size(kCapacities)],
          .seed = random(2),
          .validator = {.width = Camera::kWidth, .height = Camera::kHeight},
          .execution = random(3) % 2 == 0 ? Execution::anytime : Execution::whole,
          .when_full = static_cast<WhenFull>(random(4) % 4)};
}

// Producer: until it is refused.
struct Sender {
  Pipeline& pipeline;
  Camera& camera;
  std::uint64_t seed;
  std::uint64_t sent = 0;
  std::uint64_t outside = 0;
  std::uint64_t back = 0;
  std::uint64_t allocated = 0;

  void operator()() {
    const CounterRandom random(seed);
    for (std::uint64_t i = 0;; ++i) {
      const std::uint64_t bits = random(i);
      const std::size_t size = any_size(bits);
      const std::span<Event> events = camera.packet(size, static_cast<std::int64_t>(1 + size / 16));
      const bool spoil_place = bits >> 32 & 1;
      const bool spoil_time = (bits >> 34) % 4 == 0 && size > 1;
      Event& last = events.back();
      const std::uint16_t x = last.x;
      if (spoil_place) last.x = Camera::kWidth;
      if (spoil_time) events[size / 2].t = events.front().t - 2;  // back, inside or not
      const bool both = spoil_place && spoil_time && size == 2;   // it counts once
      const std::size_t before = test::allocations();
      const bool taken = pipeline.push(events);
      allocated += test::allocations() - before;
      last.x = x;
      if (!taken) return;
      sent += size;
      outside += spoil_place;
      back += spoil_time && !both;
    }
  }
};

// The algorithm: counts, looks at the order, and wastes time.
struct Receiver {
  BusyWait work;
  bool slow;
  std::uint64_t seen = 0;
  std::uint64_t disorder = 0;
  std::int64_t last_us = 0;
  std::size_t first_allocations = 0;
  std::size_t last_allocations = 0;

  void operator()(const Package& package) {
    last_allocations = test::allocations();
    if (seen == 0) first_allocations = last_allocations;
    for (const Event& event : package.events) {
      disorder += event.t < last_us;
      last_us = event.t;
    }
    seen += package.events.size();
    if (!slow) return;
    if (!package.continues) work.begin();
    work.process(package.events);
  }
};

bool goes_on(const Ledger& before, const Ledger& now) {
  return now.balanced() && now.received >= before.received && now.rejected >= before.rejected &&
         now.discarded >= before.discarded && now.stale >= before.stale &&
         now.overflow >= before.overflow && now.delivered >= before.delivered;
}

void one_run(Pipeline& pipeline, const RunConfig& config, Camera& camera, std::uint64_t seed,
             double seconds, Totals& totals) {
  const CounterRandom random(seed);
  Receiver receiver{.work = BusyWait({.alpha_us = 20, .beta_ns = 50}), .slow = random(5) % 2 == 0};
  Sender sender{.pipeline = pipeline, .camera = camera, .seed = random(6)};
  const bool drain = random(7) % 2 == 0;

  std::thread consumer([&] { pipeline.run([&](const Package& package) { receiver(package); }); });
  std::thread producer([&] { sender(); });
  Ledger last;
  for (const auto start = Steady::now(); seconds_since(start) < seconds;) {
    std::this_thread::sleep_for(std::chrono::microseconds(500));
    const Ledger now = pipeline.ledger();
    if (!goes_on(last, now)) ++totals.wrong;
    ++totals.snapshots;
    last = now;
  }
  const auto stop = Steady::now();
  pipeline.stop(drain);
  producer.join();
  consumer.join();
  totals.longest_stop_ms = std::max(totals.longest_stop_ms, 1e3 * seconds_since(stop));

  const PipelineStats stats = pipeline.stats();
  const Ledger& ledger = stats.ledger;
  const bool exact =
      ledger.balanced() && ledger.received == sender.sent && ledger.delivered == receiver.seen &&
      stats.rejected.out_of_bounds == sender.outside &&
      stats.rejected.nonmonotonic == sender.back && stats.latency.count() == receiver.seen &&
      stats.packages.size == receiver.seen && ledger.filtered == 0 &&
      (!drain || ledger.pending == 0) && ledger.pending <= config.capacity &&
      receiver.disorder == 0;
  if (!exact || !goes_on(last, ledger)) {
    ++totals.wrong;
    std::cerr << "ledger: seed " << seed << ": sent " << sender.sent << ", outside "
              << sender.outside << ", back " << sender.back << ", seen " << receiver.seen
              << ", disorder " << receiver.disorder << "; received " << ledger.received
              << ", outside " << stats.rejected.out_of_bounds << ", back "
              << stats.rejected.nonmonotonic << ", discarded " << ledger.discarded << ", stale "
              << ledger.stale << ", overflow " << ledger.overflow << ", delivered "
              << ledger.delivered << ", pending " << ledger.pending << '\n';
  }
  ++totals.runs;
  totals.events += sender.sent;
  totals.delivered += receiver.seen;
  totals.allocations += sender.allocated + receiver.last_allocations - receiver.first_allocations;
}

// A thread that has been joined is gone from the table soon after, not at once.
bool threads_become(std::size_t count) {
  for (const auto start = Steady::now(); seconds_since(start) < 20;) {
    if (threads() == count) return true;
    std::this_thread::yield();
  }
  return false;
}

void one_round(Camera& camera, std::uint64_t seed, Totals& totals) {
  const CounterRandom random(seed);
  const std::unique_ptr<Scheme> scheme = any_scheme(random(0));
  const RunConfig config = any_config(random);
  Pipeline pipeline(*scheme, config);
  const std::uint64_t runs = 1 + random(8) % 3;
  for (std::uint64_t run = 0; run < runs; ++run) {
    if (run > 0) pipeline.start();
    one_run(pipeline, config, camera, random(9 + run), kRoundSeconds / static_cast<double>(runs),
            totals);
  }
}

}  // namespace

void ledger(double seconds, std::uint64_t seed) {
  Camera camera(kLargestPacket, seed);
  Totals totals;
  const std::size_t threads_before = threads();
  for (const auto start = Steady::now(); seconds_since(start) < seconds;) {
    one_round(camera, seed++, totals);
    totals.threads_left += !threads_become(threads_before);
  }
  figure("ledger_runs", totals.runs);
  figure("ledger_events", totals.events);
  figure("ledger_delivered", totals.delivered);
  figure("ledger_snapshots", totals.snapshots);
  figure("ledger_wrong", totals.wrong);
  figure("hot_path_allocations", totals.allocations);
  figure("stop_threads_left", totals.threads_left);
  figure("stop_longest_ms", totals.longest_stop_ms);
}

}  // namespace asap::soak
