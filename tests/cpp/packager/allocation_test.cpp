// The hot path allocates nothing: push, ring, gamma filter, package, feed back, log.
#include <gtest/gtest.h>

#include <cstdint>
#include <cstdlib>
#include <new>
#include <string>
#include <string_view>

#include "asap/schemes/asap2020.hpp"
#include "asap/schemes/deadline.hpp"
#include "asap/schemes/fixed.hpp"
#include "asap/schemes/greedy.hpp"
#include "asap/telemetry/run_log.hpp"
#include "packager/event_times.hpp"
#include "packager/packager.hpp"
#include "support/allocation_counter.hpp"
#include "support/streams.hpp"

namespace asap::allocation_test {
namespace {

using namespace std::chrono_literals;

using test::allocations;

// How many events go through: a million, or 10^8 when the long tests are asked for.
std::uint64_t events_to_run() {
  const char* const asked = std::getenv("ASAP_LONG_TESTS");
  return asked != nullptr && std::string(asked) == "1" ? 100'000'000 : 1'000'000;
}

// Called by name: clang leaves out a `new` whose memory is not used.
TEST(Allocations, AreCounted) {
  const std::uint64_t before = allocations();
  ::operator delete(::operator new(4));
  ::operator delete[](::operator new[](400));
  constexpr std::align_val_t kWide{64};
  ::operator delete(::operator new(6400, kWide), kWide);
  EXPECT_EQ(allocations(), before + 3);
}

TEST(Allocations, TheLogGrowsByOneBlockAtATime) {
  RunLog log;
  for (std::size_t block = 1; block <= 5; ++block) {
    const std::uint64_t before = allocations();
    for (std::size_t i = 0; i < RunLog::kBlockRows; ++i) {
      log.make_room();
      log.make_room();
      log.append(PackageRecord{});
    }
    EXPECT_LE(allocations(), before + 2) << "the block, and its place in the list";
  }
}

// Asks for all that a scheme may ask for, and takes an anytime package that has to be thinned.
class Hurried final : public Scheme {
 public:
  Decision decide(const Backlog& backlog) noexcept override {
    if (backlog.count > 3000) return Decision::drop(500);
    const std::int64_t time_ns = backlog.now_ns - 1'000'000;
    const std::size_t older = backlog.counts.before(time_ns) + backlog.counts.about_before(time_ns);
    Decision decision = Decision::take(1 + older);
    decision.budget_ns = 2000;
    return decision;
  }
  std::string_view name() const noexcept override { return "hurried"; }
};

void allocates_nothing(Scheme& scheme) {
  constexpr std::size_t kBatch = 1000;
  constexpr std::size_t kRounds = 500;  // before a new packager: the log must not grow for ever
  const test::Events events = test::random_stream(1, kBatch * kRounds);
  std::uint64_t allocated = 0;
  std::uint64_t done = 0;
  std::uint64_t delivered = 0;
  while (done < events_to_run()) {
    EventBuffer buffer(4 * kBatch);
    AgeSlots ages(156'250);
    Telemetry telemetry(10'000'000);
    Packager packager(buffer, ages, scheme, telemetry, {.seed = done});
    packager.begin(TimeAxis(0, 1.0), 0);
    for (std::size_t at = 0; at < events.size(); at += kBatch, done += kBatch) {
      const std::uint64_t before = allocations();
      const EventSpan batch = EventSpan(events).subspan(at, kBatch);
      const std::uint64_t first = buffer.tail();
      const std::size_t taken = buffer.push(batch);
      ages.observe(batch.first(taken), first, [](std::int64_t stamp) { return 1000 * stamp; });
      allocated += allocations() - before;
      std::int64_t now_ns = 1000 * batch.back().t;
      for (;;) {
        telemetry.log.make_room();  // between packages: the one place that may allocate
        const std::uint64_t before_package = allocations();
        Packager::Next next = packager.next(now_ns);
        if (next.step == Packager::Step::package) {
          while (!packager.stratum(next.package, now_ns).empty()) now_ns += 500;
          packager.complete(next.package, now_ns);
        }
        allocated += allocations() - before_package;
        if (next.step != Packager::Step::package) break;
      }
    }
    delivered += telemetry.delivered;
  }
  EXPECT_EQ(allocated, 0u) << scheme.name();
  EXPECT_GT(delivered, done / 100) << scheme.name();
}

TEST(Allocations, NoneOnTheHotPath) {
  FixedSize fixed_size({.size = 37});
  allocates_nothing(fixed_size);
  FixedTime fixed_time({.period = 700us});
  allocates_nothing(fixed_time);
  SingleEvent single_event;
  allocates_nothing(single_event);
  Greedy greedy;
  allocates_nothing(greedy);
  Asap2020 asap2020({.rate_bound = 1e6, .first_size = 20});
  allocates_nothing(asap2020);
  Hurried hurried;
  allocates_nothing(hurried);
  Deadline deadline;
  allocates_nothing(deadline);
}

}  // namespace
}  // namespace asap::allocation_test
