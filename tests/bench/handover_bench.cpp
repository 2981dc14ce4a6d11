// Bar: producer and consumer together take at most as much processor time per event as a deque of
// events behind a mutex. Beside it, where they are installed: moodycamel's queue and boost's, in
// bulk, with a semaphore. A camera pushes a block every 250 us, the algorithm is empty. The ways
// take turns; medians of the rounds. Also: how often the two threads slept per block, and how long
// a block took to arrive.
//
//   handover_bench [rounds]
#include <time.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <functional>
#include <mutex>
#include <span>
#include <thread>
#include <utility>
#include <vector>

#include <sys/resource.h>

#include "asap/runner/pipeline.hpp"

#if __has_include(<concurrentqueue/blockingconcurrentqueue.h>)
#include <concurrentqueue/blockingconcurrentqueue.h>
#define ASAP_HAS_MOODYCAMEL 1
#endif
#if __has_include(<boost/lockfree/spsc_queue.hpp>)
#include <boost/lockfree/spsc_queue.hpp>
#include <semaphore>
#define ASAP_HAS_BOOST_LOCKFREE 1
#endif

namespace {

using asap::Event;
using asap::EventSpan;
using Clock = std::chrono::steady_clock;

constexpr auto kPeriod = std::chrono::microseconds(250);
constexpr int kBlocks = 1000;  // of a round

using Algorithm = std::function<void(EventSpan)>;

// What a user would write: lock, append, notify; the consumer takes all that waits.
class DequeOfEvents {
 public:
  explicit DequeOfEvents(Algorithm algorithm) : consumer_([this, algorithm] { work(algorithm); }) {}
  ~DequeOfEvents() {
    {
      const std::lock_guard lock(mutex_);
      ended_ = true;
    }
    filled_.notify_one();
    consumer_.join();
  }
  void push(EventSpan events) {
    {
      const std::lock_guard lock(mutex_);
      waiting_.insert(waiting_.end(), events.begin(), events.end());
    }
    filled_.notify_one();
  }

 private:
  void work(const Algorithm& algorithm) {
    std::vector<Event> package;
    for (;;) {
      {
        std::unique_lock lock(mutex_);
        filled_.wait(lock, [&] { return ended_ || !waiting_.empty(); });
        if (waiting_.empty()) return;
        package.assign(waiting_.begin(), waiting_.end());
        waiting_.clear();
      }
      algorithm(package);
    }
  }

  std::mutex mutex_;
  std::condition_variable filled_;
  std::deque<Event> waiting_;
  bool ended_ = false;
  std::thread consumer_;
};

constexpr std::size_t kRoom = std::size_t{1} << 20;  // events, of a queue and of a package

// A queue in bulk; a block of one event that no camera makes ends it.
template <class Queue>
class Bulk {
 public:
  explicit Bulk(Algorithm algorithm) : consumer_([this, algorithm] { work(algorithm); }) {}
  ~Bulk() {
    while (!queue_.push(std::array{kEnd})) std::this_thread::yield();  // it may be full
    consumer_.join();
  }
  void push(EventSpan events) { queue_.push(events); }

 private:
  static constexpr Event kEnd{.x = 0, .y = 0, .p = -1, .t = 0};

  void work(const Algorithm& algorithm) {
    std::vector<Event> package(kRoom);
    for (;;) {
      const std::size_t size = queue_.pop(package);
      if (size == 0) continue;
      if (package[size - 1].p == kEnd.p) return;
      algorithm({package.data(), size});
    }
  }

  Queue queue_;
  std::thread consumer_;
};

#ifdef ASAP_HAS_MOODYCAMEL
struct Moodycamel {
  using Queue = moodycamel::BlockingConcurrentQueue<Event>;

  bool push(EventSpan events) { return queue.enqueue_bulk(producer, events.data(), events.size()); }
  std::size_t pop(std::span<Event> out) {
    return queue.wait_dequeue_bulk(consumer, out.data(), out.size());
  }

  Queue queue{kRoom};
  moodycamel::ProducerToken producer{queue};
  moodycamel::ConsumerToken consumer{queue};
};
#endif

#ifdef ASAP_HAS_BOOST_LOCKFREE
struct Boost {
  bool push(EventSpan events) {
    const bool is_taken = queue.push(events.data(), events.size()) > 0;
    filled.release();
    return is_taken;
  }
  std::size_t pop(std::span<Event> out) {
    filled.acquire();
    return queue.pop(out.data(), out.size());
  }

  boost::lockfree::spsc_queue<Event> queue{kRoom};
  std::counting_semaphore<> filled{0};
};
#endif

class Asap {
 public:
  explicit Asap(const Algorithm& algorithm) : pipeline_({}, algorithm) {}
  ~Asap() {
    pipeline_.stop();
    pipeline_.join();
  }
  void push(EventSpan events) { pipeline_.push(events); }

 private:
  asap::Pipeline pipeline_;
};

// The camera alone: what each way takes in any case.
class Nothing {
 public:
  explicit Nothing(const Algorithm&) {}
  void push(EventSpan) {}
};

struct Round {
  double cpu_ns;   // per event
  double sleeps;   // per block, of both threads
  double late_us;  // from a block's due time to its arrival at the algorithm, median
};

std::int64_t cpu_ns() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return now.tv_sec * std::int64_t{1'000'000'000} + now.tv_nsec;
}

long sleeps() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_nvcsw;
}

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

template <class Way>
Round measure(std::size_t events_per_block) {
  std::vector<Event> block(events_per_block);
  for (std::size_t i = 0; i < block.size(); ++i) {
    block[i] = {.x = static_cast<std::uint16_t>(i % 346),
                .y = static_cast<std::uint16_t>(i % 260),
                .p = static_cast<std::int16_t>(i & 1),
                .t = static_cast<std::int64_t>(i * kPeriod.count() / block.size())};
  }
  std::vector<double> late_us;
  late_us.reserve(std::size_t{kBlocks});
  Clock::time_point start{};
  const Algorithm algorithm = [&](EventSpan events) {
    const auto due = start + std::chrono::microseconds(events.back().t);
    if (late_us.size() < late_us.capacity()) {
      late_us.push_back(std::chrono::duration<double, std::micro>(Clock::now() - due).count());
    }
  };
  std::int64_t cpu = 0;
  long slept = 0;
  {
    Way way(algorithm);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));  // its thread is there
    start = Clock::now();
    cpu = cpu_ns();
    slept = sleeps();
    for (int i = 1; i <= kBlocks; ++i) {
      std::this_thread::sleep_until(start + i * kPeriod);
      way.push(block);
      for (Event& event : block) event.t += kPeriod.count();
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    cpu = cpu_ns() - cpu;
    slept = sleeps() - slept;
  }
  const auto events = static_cast<double>(events_per_block) * kBlocks;
  return {.cpu_ns = static_cast<double>(cpu) / events,
          .sleeps = static_cast<double>(slept) / kBlocks,
          .late_us = median(late_us)};
}

}  // namespace

int main(int argc, char** argv) {
  const int rounds = argc > 1 ? std::max(1, std::atoi(argv[1])) : 15;  // an option: one
  constexpr std::array kNames{"asap", "deque of events",
#ifdef ASAP_HAS_MOODYCAMEL
                              "moodycamel",
#endif
#ifdef ASAP_HAS_BOOST_LOCKFREE
                              "boost",
#endif
                              "camera alone"};
  constexpr std::array kWays{&measure<Asap>, &measure<DequeOfEvents>,
#ifdef ASAP_HAS_MOODYCAMEL
                             &measure<Bulk<Moodycamel>>,
#endif
#ifdef ASAP_HAS_BOOST_LOCKFREE
                             &measure<Bulk<Boost>>,
#endif
                             &measure<Nothing>};
  std::printf("%6s  %-17s %12s %8s %14s %12s\n", "Mev/s", "", "ns per event", "ratio",
              "sleeps / block", "latency, us");
  for (const std::size_t rate : {1UL, 5UL, 50UL}) {
    std::array<std::array<std::vector<double>, 4>, kWays.size()> seen;
    for (int round = 0; round < rounds; ++round) {
      std::array<Round, kWays.size()> now{};
      for (std::size_t i = 0; i < kWays.size(); ++i) {
        const std::size_t way = (i + static_cast<std::size_t>(round)) % kWays.size();
        now[way] = kWays[way](rate * static_cast<std::size_t>(kPeriod.count()));
      }
      for (std::size_t way = 0; way < kWays.size(); ++way) {
        seen[way][0].push_back(now[way].cpu_ns);
        seen[way][1].push_back(now.front().cpu_ns / now[way].cpu_ns);
        seen[way][2].push_back(now[way].sleeps);
        seen[way][3].push_back(now[way].late_us);
      }
    }
    for (std::size_t way = 0; way < kWays.size(); ++way) {
      std::printf("%6zu  %-17s %12.2f %8.2f %14.2f %12.0f\n", rate, kNames[way],
                  median(seen[way][0]), median(seen[way][1]), median(seen[way][2]),
                  median(seen[way][3]));
    }
  }
}
