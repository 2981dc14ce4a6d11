#include "schemes/work_by_age.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "support/fake_backlog.hpp"

namespace asap {
namespace {

constexpr std::int64_t kNow = 1'000'000'000;
constexpr double kSpan = 3.2e6;  // slots of 100 us
constexpr double kEvent = 1000;

// One event each 1 us, of ages from 1 us to 2 ms; none younger than `from`.
test::FakeBacklog evenly(int from_us = 1) {
  std::vector<std::int64_t> times;
  for (int age_us = 2000; age_us >= from_us; --age_us) times.push_back(kNow - 1000 * age_us);
  return test::FakeBacklog(times);
}

TEST(WorkByAge, CountsTheWorkUpToAnAge) {
  const test::FakeBacklog events = evenly();
  const WorkByAge work(events.at(kNow), kSpan, kEvent);
  EXPECT_EQ(work.up_to(-1), 0);
  EXPECT_EQ(work.up_to(0), 0);
  EXPECT_NEAR(work.up_to(1e6), 1000 * kEvent, 1e-6);
  EXPECT_NEAR(work.up_to(1.05e6), 1050 * kEvent, 1e-6);  // in the middle of a slot
  EXPECT_NEAR(work.up_to(5e6), 2000 * kEvent, 1e-6);
  EXPECT_NEAR(work.age_of(1050 * kEvent), 1.05e6, 1e-6);
  EXPECT_EQ(work.age_of(0), 0);
  EXPECT_EQ(work.age_of(2001 * kEvent), kSpan);
}

// None up to 500 us, then 1 us of work each us: what stays is done as fast as it gets old.
TEST(WorkByAge, TellsWhatCanBeDoneInTime) {
  const test::FakeBacklog events = evenly(501);
  const WorkByAge work(events.at(kNow), kSpan, kEvent);
  EXPECT_NEAR(work.age_done_within(250e3), 250e3, 1e-6);
  EXPECT_NEAR(work.age_done_within(499e3), 499e3, 1e-6);
  // From 500 us on C(x) + max(a - C(a)) rises by the work alone, as that is 1.
  EXPECT_NEAR(work.age_done_within(900e3), 900e3, 1e-6);
  const WorkByAge dear(events.at(kNow), kSpan, 3 * kEvent);
  EXPECT_NEAR(dear.age_done_within(1.1e6), 700e3, 1e-6);  // 500 us and 200 events of 3 us
}

// a + C(y) = L - y.
TEST(WorkByAge, FindsThePackageOfTheNewest) {
  const test::FakeBacklog events = evenly();
  const WorkByAge dear(events.at(kNow), kSpan, 3 * kEvent);
  EXPECT_NEAR(dear.newest_only(400e3, 1.0), 400e3 + 3 * 700e3, 1e-6);            // y = 700 us
  EXPECT_NEAR(dear.newest_only(800e3, 2.0), 2 * (400e3 + 3 * 2.4e6 / 7), 1e-6);  // 2.4 / 7 ms
  const WorkByAge cheap(events.at(kNow), kSpan, 0.1 * kEvent);
  EXPECT_NEAR(cheap.newest_only(1e3, 1.0), 201e3, 1e-6);  // all of them
}

}  // namespace
}  // namespace asap
