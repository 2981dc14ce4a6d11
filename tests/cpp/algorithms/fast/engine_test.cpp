#include "algorithms/fast/engine.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "core/random.hpp"

namespace asap::fast::engine_test {
namespace {

// A ring of events that moves and stops: the outline of a disk, leading edge ON.
struct Disk {
  double x = 60;
  double y = 60;
  double vx = 100;
  double vy = 0;
  double radius = 8;
};

void add_disk(std::vector<Event>& events, const Disk& disk, double from_s, double to_s,
              double rate_hz = 10'000, std::uint64_t seed = 1) {
  const CounterRandom random(seed);
  std::uint64_t drawn = 0;
  for (double t = from_s; t < to_s; t += 1 / rate_hz) {
    const double angle = 6.2831853 * random.uniform(drawn++);
    const double r = disk.radius + random.uniform(drawn++) - 0.5;
    const double x = disk.x + disk.vx * t + r * std::cos(angle);
    const double y = disk.y + disk.vy * t + r * std::sin(angle);
    events.push_back({.x = static_cast<std::uint16_t>(x),
                      .y = static_cast<std::uint16_t>(y),
                      .p = static_cast<std::int16_t>(std::cos(angle) > 0),
                      .t = static_cast<std::int64_t>(1e6 * t)});
  }
}

void add_noise(std::vector<Event>& events, double rate_hz, double to_s) {
  const CounterRandom random(7);
  std::uint64_t drawn = 0;
  if (rate_hz == 0) return;
  const double step_s = 1 / (rate_hz * 346 * 260);
  for (double t = step_s; t < to_s; t += step_s) {
    events.push_back({.x = static_cast<std::uint16_t>(346 * random.uniform(drawn++)),
                      .y = static_cast<std::uint16_t>(260 * random.uniform(drawn++)),
                      .p = static_cast<std::int16_t>(random.uniform(drawn++) < 0.5),
                      .t = static_cast<std::int64_t>(1e6 * t)});
  }
}

void sort_by_time(std::vector<Event>& events) {
  std::stable_sort(events.begin(), events.end(),
                   [](const Event& a, const Event& b) { return a.t < b.t; });
}

std::vector<Cluster> clusters_of(const Engine& engine) {
  std::vector<Cluster> clusters;
  engine.read(engine.latest_us(), clusters);
  return clusters;
}

std::vector<TrackedObject> objects_of(const Engine& engine) {
  std::vector<TrackedObject> objects;
  engine.read(engine.latest_us(), objects);
  return objects;
}

constexpr ClusterTrackerConfig kFrame{.width = 346, .height = 260};

TEST(Engine, FollowsADisk) {
  std::vector<Event> events;
  add_disk(events, {}, 0, 1);
  Engine engine(kFrame);
  std::vector<std::int32_t> labels(events.size());
  engine.process(events, labels.data());
  const auto clusters = clusters_of(engine);
  ASSERT_EQ(clusters.size(), 1U);
  EXPECT_EQ(clusters[0].id, 0);
  EXPECT_NEAR(clusters[0].x, 159.5, 1);  // pixels are cut off, not rounded
  EXPECT_NEAR(clusters[0].y, 59.5, 1);
  EXPECT_NEAR(clusters[0].vx, 100, 15);
  EXPECT_NEAR(clusters[0].vy, 0, 15);
  EXPECT_NEAR(clusters[0].cxx, 32, 8);  // of a ring: half the squared radius
  EXPECT_EQ(clusters[0].t_last, events.back().t);
  const std::set<std::int32_t> late(labels.begin() + 3000, labels.end());
  EXPECT_EQ(late, (std::set<std::int32_t>{-1, 0}));
  EXPECT_LT(std::count(labels.begin() + 3000, labels.end(), -1), 700);  // without support
}

// Before noise has been measured once.
TEST(Engine, ADiskIsListedSoonAfterTheStart) {
  std::vector<Event> events;
  add_disk(events, {}, 0, 0.012);
  Engine engine(kFrame);
  engine.process(events, nullptr);
  EXPECT_EQ(clusters_of(engine).size(), 1U);
}

// The disk moves 12 px in 60 events, the longest memory of a mean.
TEST(Engine, TheMeanOfASmallDiskDoesNotLag) {
  constexpr Disk kSmall{.vx = 400, .radius = 1.5};
  std::vector<Event> events;
  add_disk(events, kSmall, 0, 0.25, 2000);
  Engine engine(kFrame);
  for (const Event& event : events) {
    engine.process({&event, 1}, nullptr);
    for (const Cluster& cluster : clusters_of(engine)) {
      const double centre = kSmall.x - 0.5 + kSmall.vx * 1e-6 * static_cast<double>(event.t);
      ASSERT_NEAR(cluster.x, centre, 3) << event.t << " us";
    }
  }
}

TEST(Engine, CrossingDisksKeepTheirIds) {
  std::vector<Event> events;
  add_disk(events, {.x = 50, .y = 100, .vx = 150}, 0, 1.2);
  add_disk(events, {.x = 230, .y = 108, .vx = -150}, 0, 1.2, 10'000, 2);
  sort_by_time(events);
  Engine engine(kFrame);
  engine.process(events, nullptr);
  const auto clusters = clusters_of(engine);
  ASSERT_EQ(clusters.size(), 2U);
  std::vector<Event> half(events.begin(), events.begin() + 4000);
  Engine before(kFrame);
  before.process(half, nullptr);
  const auto early = clusters_of(before);
  ASSERT_EQ(early.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(clusters[i].id, early[i].id);
    EXPECT_GT(clusters[i].vx * early[i].vx, 0);
  }
}

// Lost packets, say: nothing comes from the sensor for 50 ms.
TEST(Engine, AGapOfTheSensorKeepsTheIds) {
  std::vector<Event> events;
  add_disk(events, {.x = 50, .y = 60, .vx = 150}, 0, 0.5);
  add_disk(events, {.x = 230, .y = 160, .vx = -150}, 0, 0.5, 10'000, 2);
  sort_by_time(events);
  std::erase_if(events, [](const Event& event) { return event.t >= 300'000 && event.t < 350'000; });
  const auto middle = std::partition_point(events.begin(), events.end(),
                                           [](const Event& event) { return event.t < 300'000; });
  Engine engine(kFrame);
  engine.process({events.begin(), middle}, nullptr);
  const auto before = clusters_of(engine);
  ASSERT_EQ(before.size(), 2U);
  engine.process({middle, middle + 1}, nullptr);
  EXPECT_EQ(clusters_of(engine).size(), 2U);
  engine.process({middle + 1, events.end()}, nullptr);
  const auto after = clusters_of(engine);
  ASSERT_EQ(after.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) EXPECT_EQ(after[i].id, before[i].id);
}

TEST(Engine, TwoEdgesOfALargeObjectAreOne) {
  std::vector<Event> events;
  add_disk(events, {.x = 60, .y = 120, .vx = 200, .radius = 20}, 0, 0.8, 30'000);
  Engine engine(kFrame);
  engine.process(events, nullptr);
  EXPECT_EQ(clusters_of(engine).size(), 1U);
}

TEST(Engine, ObjectsThatSeparateAreSplit) {
  std::vector<Event> events;
  add_disk(events, {.x = 100, .y = 100, .vx = 0, .radius = 5}, 0, 1);
  Disk other{.x = 104, .y = 100, .vx = 0, .radius = 5};
  add_disk(events, other, 0, 0.3, 10'000, 2);
  other.vx = 150;
  other.x -= 0.3 * 150;
  add_disk(events, other, 0.3, 1, 10'000, 2);
  sort_by_time(events);
  Engine engine(kFrame);
  engine.process(events, nullptr);
  EXPECT_EQ(clusters_of(engine).size(), 2U);
}

TEST(Engine, ObjectsThatSeparateSlowlyAreSplit) {
  std::vector<Event> events;
  add_disk(events, {.x = 100, .y = 100, .vx = 0, .radius = 5}, 0, 1.4);
  Disk other{.x = 104, .y = 100, .vx = 18, .radius = 5};
  add_disk(events, other, 0, 1.4, 10'000, 2);
  sort_by_time(events);
  Engine engine(kFrame);
  engine.process(events, nullptr);
  EXPECT_EQ(clusters_of(engine).size(), 2U);
}

TEST(Engine, UnresolvedObjectsAreSplitSoon) {
  std::vector<Event> events;
  add_disk(events, {.x = 60, .y = 90, .vx = 100, .vy = -40}, 0, 0.6);
  add_disk(events, {.x = 60, .y = 106, .vx = 100, .vy = 40}, 0, 0.6, 10'000, 2);
  sort_by_time(events);
  Engine engine(kFrame);
  const auto at = [&](std::int64_t t_us) {
    const auto begin = std::partition_point(events.begin(), events.end(), [&](const Event& event) {
      return event.t <= engine.latest_us();
    });
    const auto end = std::partition_point(events.begin(), events.end(),
                                          [&](const Event& event) { return event.t < t_us; });
    engine.process({&*begin, static_cast<std::size_t>(end - begin)}, nullptr);
    return clusters_of(engine);
  };
  EXPECT_EQ(at(70'000).size(), 1U);
  const auto early = at(200'000);
  ASSERT_EQ(early.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    const bool upper = early[i].y < 100;
    EXPECT_NEAR(early[i].x, 79.5, 3);
    EXPECT_NEAR(early[i].y, upper ? 81.5 : 113.5, 3);
  }
  EXPECT_EQ(early[0].id, 0);
  EXPECT_EQ(early[1].id, 1);
  const auto late = at(600'000);
  ASSERT_EQ(late.size(), 2U);
  EXPECT_EQ(late[0].id, early[0].id);
  EXPECT_EQ(late[1].id, early[1].id);
}

TEST(Engine, NoiseAloneIsNotACluster) {
  for (const double rate_hz : {0.5, 5.0, 20.0}) {
    for (const auto support :
         {ClusterSupport::kOff, ClusterSupport::kEstimate, ClusterSupport::kReject}) {
      ClusterTrackerConfig config = kFrame;
      config.support = support;
      Engine engine(config);
      const CounterRandom random(7);
      const double step_us = 1e6 / (rate_hz * config.width * config.height);
      for (std::uint64_t i = 0; static_cast<double>(i) * step_us < 0.5e6; ++i) {
        const Event event{.x = static_cast<std::uint16_t>(random(2 * i) % 346),
                          .y = static_cast<std::uint16_t>(random(2 * i + 1) % 260),
                          .p = 1,
                          .t = static_cast<std::int64_t>(static_cast<double>(i) * step_us)};
        std::int32_t label = 0;
        engine.process({&event, 1}, &label);
        ASSERT_EQ(label, -1) << rate_hz;
      }
    }
  }
}

// Root mean square error of the velocity of a disk of 100 px/s, seen every 5 ms.
double velocity_error(double noise_hz) {
  std::vector<Event> events;
  add_disk(events, {}, 0, 2);
  add_noise(events, noise_hz, 2);
  sort_by_time(events);
  Engine engine(kFrame);
  double sum = 0;
  int seen = 0;
  std::int64_t next_us = 200'000;
  for (const Event& event : events) {
    engine.process({&event, 1}, nullptr);
    if (event.t < next_us) continue;
    next_us += 5'000;
    for (const Cluster& cluster : clusters_of(engine)) {
      sum += (cluster.vx - 100) * (cluster.vx - 100) + cluster.vy * cluster.vy;
      ++seen;
    }
  }
  return std::sqrt(sum / seen);
}

TEST(Engine, NoiseAroundAnObjectDoesNotMoveIt) {
  EXPECT_LT(velocity_error(0), 10);
  EXPECT_LT(velocity_error(8), 14);
}

TEST(Engine, ASlowEdgeHasSupportInLittleNoise) {
  std::vector<Event> events;
  add_disk(events, {.vx = 10, .radius = 11}, 0, 0.6, 1'500);
  Engine engine(kFrame);
  engine.process(events, nullptr);
  EXPECT_LT(engine.counters().unsupported, events.size() / 2);
  EXPECT_EQ(clusters_of(engine).size(), 1U);
}

TEST(Engine, ANewTrackIsNotConfirmedBeforeItsNeighboursAreKnown) {
  Engine engine(kFrame);
  std::vector<Event> events;
  add_disk(events, {}, 0, 0.5);
  // 12 px ahead of it, with more events at once than a confirmation needs.
  for (std::int64_t i = 0; i < 60; ++i) {
    events.push_back({.x = static_cast<std::uint16_t>(129 + i % 3),
                      .y = static_cast<std::uint16_t>(59 + i / 3 % 3),
                      .p = 1,
                      .t = 499'000 + 10 * i});
  }
  sort_by_time(events);
  engine.process(events, nullptr);
  engine.advance_to(502'000);
  EXPECT_EQ(clusters_of(engine).size(), 1U);
}

TEST(Engine, UnsupportedEventsAreCountedEvenIfNotRejected) {
  ClusterTrackerConfig config = kFrame;
  std::vector<Event> events(10, Event{.x = 50, .y = 50, .p = 1, .t = 5});
  for (const auto support : {ClusterSupport::kEstimate, ClusterSupport::kReject}) {
    config.support = support;
    Engine engine(config);
    engine.process(events, nullptr);
    EXPECT_EQ(engine.counters().unsupported, 10U);
  }
  config.support = ClusterSupport::kOff;
  Engine engine(config);
  engine.process(events, nullptr);
  EXPECT_EQ(engine.counters().unsupported, 0U);
}

// Ids that the engine gives to a disk in its first half second, with noise.
std::size_t ids_of_disk(double radius, std::uint64_t seed) {
  std::vector<Event> events;
  add_disk(events, {.x = 100, .y = 100, .radius = radius}, 0, 0.5, 10'000, seed);
  add_noise(events, 1, 0.5);
  sort_by_time(events);
  Engine engine(kFrame);
  std::vector<std::int32_t> labels(events.size());
  engine.process(events, labels.data());
  std::set<std::int32_t> ids(labels.begin(), labels.end());
  ids.erase(-1);
  return ids.size();
}

// With a gate of 18 px alone they are 66. One each would be 18.
TEST(Engine, LargeDisksAreBornInFewParts) {
  EXPECT_EQ(ids_of_disk(8, 1), 1U);
  std::size_t ids = 0;
  for (const double radius : {20.0, 24.0, 28.0}) {
    for (std::uint64_t seed = 1; seed <= 6; ++seed) ids += ids_of_disk(radius, seed);
  }
  EXPECT_LE(ids, 45U);
}

TEST(Engine, AStoppedObjectKeepsItsId) {
  for (const double gap_s : {0.1, 0.2, 0.3}) {
    std::vector<Event> events;
    add_disk(events, {}, 0, 0.7);
    Engine engine(kFrame);
    engine.process(events, nullptr);
    engine.advance_to(static_cast<std::int64_t>(1e6 * (0.7 + gap_s)));
    EXPECT_TRUE(clusters_of(engine).empty()) << gap_s;
    EXPECT_TRUE(objects_of(engine).empty()) << gap_s;
    events.clear();
    add_disk(events, {.x = 60 - 100 * gap_s}, 0.7 + gap_s, 1.4 + gap_s);
    engine.process(events, nullptr);
    const auto objects = objects_of(engine);
    ASSERT_EQ(objects.size(), 1U) << gap_s;
    EXPECT_EQ(objects[0].id, 0) << gap_s;
  }
}

TEST(Engine, AStoppedObjectIsFoundWhereItStopped) {
  std::vector<Event> events;
  add_disk(events, {.vx = 200, .radius = 11}, 0, 0.7, 30'000);
  Engine engine(kFrame);
  engine.process(events, nullptr);
  engine.advance_to(1'000'000);
  events.clear();
  add_disk(events, {.x = 400, .vx = -200, .radius = 11}, 1.0, 1.02, 30'000);
  engine.process(events, nullptr);
  const auto objects = objects_of(engine);
  ASSERT_EQ(objects.size(), 1U);
  EXPECT_EQ(objects[0].id, 0);
  EXPECT_NEAR(objects[0].x, 198, 6);
}

TEST(Engine, AnObjectKeepsItsIdThroughAnOcclusion) {
  std::vector<Event> events;
  add_disk(events, {.vx = 150}, 0, 0.7);
  add_disk(events, {.vx = 150}, 1.0, 1.5);
  Engine engine(kFrame);
  engine.process(events, nullptr);
  const auto objects = objects_of(engine);
  ASSERT_EQ(objects.size(), 1U);
  EXPECT_EQ(objects[0].id, 0);
}

TEST(Engine, AfterALongTimeTheIdIsNew) {
  std::vector<Event> events;
  add_disk(events, {.vx = 0}, 0, 0.5);
  add_disk(events, {.vx = 0}, 1.5, 2);
  Engine engine(kFrame);
  engine.process(events, nullptr);
  const auto objects = objects_of(engine);
  ASSERT_EQ(objects.size(), 1U);
  EXPECT_EQ(objects[0].id, 1);
}

}  // namespace
}  // namespace asap::fast::engine_test
