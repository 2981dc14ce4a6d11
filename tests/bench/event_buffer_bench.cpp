// Bar: at least half the throughput of boost::lockfree::spsc_queue in the same run, at every batch
// size, although ours counts what it drops and hands out contiguous pieces.
#include "buffer/event_buffer.hpp"

#include <benchmark/benchmark.h>

#include <cstdint>
#include <thread>
#include <vector>

#include "per_event.hpp"
#include "support/streams.hpp"

#if __has_include(<boost/lockfree/spsc_queue.hpp>)
#include <boost/lockfree/spsc_queue.hpp>
#define ASAP_HAS_BOOST_LOCKFREE 1
#endif

namespace {

using asap::Event;
using asap::EventSpan;

constexpr std::size_t kCapacity = std::size_t{1} << 16;
constexpr std::uint64_t kEventsPerRun = 4'000'000;

// The two rings behind one form: both sides move the events once, as a consumer that copies does.
struct OurRing {
  asap::EventBuffer ring{kCapacity};

  std::size_t push(EventSpan events) { return ring.push(events); }
  std::size_t pop(Event* out, std::size_t limit) {
    const asap::EventPieces pieces = ring.peek(limit);
    std::copy_n(pieces.first.data(), pieces.first.size(), out);
    std::copy_n(pieces.second.data(), pieces.second.size(), out + pieces.first.size());
    ring.consume(pieces.size());
    return pieces.size();
  }
};

// The form that the library uses: no copy at all on the consumer's side.
struct OurRingInPlace {
  asap::EventBuffer ring{kCapacity};

  std::size_t push(EventSpan events) { return ring.push(events); }
  std::size_t pop(Event*, std::size_t limit) {
    const asap::EventPieces pieces = ring.peek(limit);
    std::int64_t sum = 0;
    for (const Event& event : pieces.first) sum += event.t;
    for (const Event& event : pieces.second) sum += event.t;
    benchmark::DoNotOptimize(sum);
    ring.consume(pieces.size());
    return pieces.size();
  }
};

#ifdef ASAP_HAS_BOOST_LOCKFREE
struct BoostRing {
  boost::lockfree::spsc_queue<Event> ring{kCapacity};

  std::size_t push(EventSpan events) { return ring.push(events.data(), events.size()); }
  std::size_t pop(Event* out, std::size_t limit) { return ring.pop(out, limit); }
};
#endif

template <class Ring>
void one_thread(benchmark::State& state) {
  const auto batch = static_cast<std::size_t>(state.range(0));
  const std::vector<Event> events = asap::test::evenly_spaced(batch, 1);
  std::vector<Event> out(batch);
  Ring ring;
  for (auto _ : state) {
    benchmark::DoNotOptimize(ring.push(events));
    benchmark::DoNotOptimize(ring.pop(out.data(), batch));
    benchmark::ClobberMemory();
  }
  asap::bench::report_events(state, batch);
}

template <class Ring>
void two_threads(benchmark::State& state) {
  const auto batch = static_cast<std::size_t>(state.range(0));
  const std::vector<Event> events = asap::test::evenly_spaced(batch, 1);
  std::vector<Event> out(batch);
  for (auto _ : state) {
    Ring ring;
    std::thread producer([&] {
      for (std::uint64_t pushed = 0; pushed < kEventsPerRun;) {
        const std::size_t size = std::min<std::uint64_t>(batch, kEventsPerRun - pushed);
        const std::size_t taken = ring.push(EventSpan(events).first(size));
        pushed += taken;
        if (taken == 0) std::this_thread::yield();
      }
    });
    for (std::uint64_t popped = 0; popped < kEventsPerRun;) {
      const std::size_t taken = ring.pop(out.data(), batch);
      popped += taken;
      if (taken == 0) std::this_thread::yield();
    }
    producer.join();
  }
  asap::bench::report_events(state, kEventsPerRun);
}

#define ASAP_BENCH_RING(Ring)                                                            \
  BENCHMARK_TEMPLATE(one_thread, Ring)->ArgName("batch")->Arg(1)->Arg(100)->Arg(10'000); \
  BENCHMARK_TEMPLATE(two_threads, Ring)                                                  \
      ->ArgName("batch")                                                                 \
      ->Arg(1)                                                                           \
      ->Arg(100)                                                                         \
      ->Arg(10'000)                                                                      \
      ->UseRealTime()                                                                    \
      ->Unit(benchmark::kMillisecond)

ASAP_BENCH_RING(OurRing);
ASAP_BENCH_RING(OurRingInPlace);
#ifdef ASAP_HAS_BOOST_LOCKFREE
ASAP_BENCH_RING(BoostRing);
#endif

}  // namespace
