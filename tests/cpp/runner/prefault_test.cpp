#include "runner/prefault.hpp"

#include <gtest/gtest.h>

#include "asap/runner/pipeline.hpp"
#include "support/streams.hpp"

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#include <malloc.h>
#include <sys/prctl.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <thread>

namespace asap::prefault_test {
namespace {

// Minor page faults of the process so far. Under an emulator they include those of the emulator.
long page_faults() noexcept {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_minflt;
}

#if defined(__x86_64__)
constexpr long kMost = 0;
#else
constexpr long kMost = 1;  // an emulator has faults of its own
#endif

struct Seen {
  long faults;
  Ledger ledger;
};

// A million events through a new pipeline, some bad, in time and, at the end, faster than they are
// taken.
Seen run_million(bool prefault) {
  test::Events events = test::evenly_spaced(1000, 1);
  malloc_trim(0);  // no page of what was freed before
  Pipeline pipeline{{.latency_us = 10'000,
                     .capacity = 65'536,
                     .validator = {.width = 4000},
                     .prefault = prefault},
                    [](EventSpan) {}};
  const long before = page_faults();
  for (int push = 0; push < 1000; ++push) {
    events[7].x = push % 10 == 0 ? 5000 : 1;
    pipeline.push(events);
    for (Event& event : events) event.t += 1000;
    if (push < 500) std::this_thread::sleep_for(std::chrono::microseconds(50));
  }
  const long faults = page_faults() - before;
  pipeline.stop();
  pipeline.join();
  return {faults, pipeline.ledger()};
}

// A page that was not touched is missed every time; one that the kernel moves meanwhile, once.
int exit_code() {
  prctl(PR_SET_THP_DISABLE, 1, 0, 0, 0);  // a huge page is one fault
  const long without = run_million(false).faults;
  long least = without;
  for (int attempt = 0; attempt < 5 && least > 0; ++attempt) {
    const Seen seen = run_million(true);
    least = std::min(least, seen.ledger.received == 1'000'000 ? seen.faults : 1000);
  }
  std::fprintf(stderr, "faults without prefault: %ld, with it: %ld\n", without, least);
  return least <= kMost && without > 100 ? 0 : 1;
}

// In a process of its own: the heap of the tests before has pages to give.
TEST(Prefault, NoPageIsMissedOnTheHotPath) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(std::exit(exit_code()), testing::ExitedWithCode(0), "with it: [01]\n");
}

}  // namespace
}  // namespace asap::prefault_test
#endif

namespace asap::prefault_test {
namespace {

TEST(Prefault, TouchesWithoutHarm) {
  touch_code();
  touch_stack();
}

}  // namespace
}  // namespace asap::prefault_test
