#include "algorithms/cluster_motion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

namespace cluster_motion_test {
namespace {

using asap::ClusterMotion;
using asap::Vector2;
using asap::WindowMoments;

constexpr std::int64_t kUnixTime_us = 1'600'000'000'000'000;

// A blob of events, 100 us apart, from (100, 100) px at (vx, vy) px/s.
class Blob {
 public:
  Blob(std::int64_t start_us, double vx, double vy) : start_us_(start_us), vx_(vx), vy_(vy) {
    motion.begin({100, 100}, start_us);
  }

  void move_for(std::int64_t us) {
    for (const std::int64_t end = now_us_ + us; now_us_ < end;) {
      now_us_ += 100;
      const auto pixel = [this](double centre) {
        return static_cast<std::uint64_t>(centre + 0.5 + jitter_(random_));
      };
      const Vector2 centre = truth();
      const auto x = pixel(centre.x), y = pixel(centre.y);
      moments.add(x, y, now());
      motion.take(x, y, now(), moments);
    }
  }

  std::int64_t now() const { return start_us_ + now_us_; }
  Vector2 truth() const {
    const double s = 1e-6 * static_cast<double>(now_us_);
    return {100 + vx_ * s, 100 + vy_ * s};
  }

  ClusterMotion motion;
  WindowMoments moments;

 private:
  std::int64_t start_us_;
  std::int64_t now_us_ = 0;
  double vx_, vy_;
  std::mt19937_64 random_{1};
  std::uniform_real_distribution<double> jitter_{-4, 4};
};

TEST(ClusterMotion, FindsPositionAndVelocity) {
  for (const std::int64_t start : {std::int64_t{0}, -kUnixTime_us, kUnixTime_us}) {
    Blob blob(start, 300, -80);
    blob.move_for(400'000);
    EXPECT_NEAR(blob.motion.velocity().x, 300, 60);
    EXPECT_NEAR(blob.motion.velocity().y, -80, 60);
    EXPECT_NEAR(blob.motion.position_at(blob.now()).x, blob.truth().x, 1);
    EXPECT_NEAR(blob.motion.position_at(blob.now()).y, blob.truth().y, 1);
  }
}

TEST(ClusterMotion, BeginsAtRestInItsCentre) {
  ClusterMotion motion;
  motion.begin({12.5, 7.25}, kUnixTime_us);
  EXPECT_EQ(motion.velocity().x, 0);
  EXPECT_EQ(motion.velocity().y, 0);
  EXPECT_EQ(motion.position_at(kUnixTime_us + 50'000).x, 12.5);
  EXPECT_EQ(motion.position_at(kUnixTime_us + 50'000).y, 7.25);
}

TEST(ClusterMotion, MeasuresWithEightEventsOfAMillisecond) {
  WindowMoments moments;
  ClusterMotion motion;
  const auto take = [&](std::int64_t t_us, int count) {
    for (int i = 0; i < count; ++i) {
      moments.add(20, 10, t_us);
      motion.take(20, 10, t_us, moments);
    }
    return motion.velocity().x;
  };
  motion.begin({10, 10}, 0);
  EXPECT_EQ(take(2000, 7), 0);
  EXPECT_GT(take(2000, 1), 0);
  motion.begin({10, 10}, 0);
  EXPECT_EQ(take(0, 100), 0);
  EXPECT_EQ(take(1999, 100), 0);  // mean age 0.9995 ms
  EXPECT_GT(take(2000, 1), 0);
}

TEST(ClusterMotion, PredictsAHundredMillisecondsAndNotThePast) {
  Blob blob(kUnixTime_us, 300, -80);
  blob.move_for(400'000);
  const auto at = [&](std::int64_t ahead_us) {
    return blob.motion.position_at(blob.now() + ahead_us);
  };
  EXPECT_NEAR(at(50'000).x, at(0).x + 0.05 * blob.motion.velocity().x, 1e-9);
  EXPECT_NEAR(at(50'000).y, at(0).y + 0.05 * blob.motion.velocity().y, 1e-9);
  EXPECT_LT(at(90'000).x, at(200'000).x);
  EXPECT_EQ(at(200'000).x, at(std::int64_t{1} << 62).x);
  EXPECT_EQ(at(-50'000).x, at(-100'000).x);
  EXPECT_LT(at(-50'000).x, at(0).x);  // the measurement is older than the last event
}

TEST(ClusterMotion, BeginsAnewASecondAfterTheLastMeasurement) {
  for (const std::int64_t gap : {std::int64_t{1'100'000}, std::int64_t{-2'000'000}}) {
    Blob blob(kUnixTime_us, 300, 0);
    blob.move_for(400'000);
    WindowMoments moments;
    moments.add(7, 9, blob.now() + gap);
    blob.motion.take(7, 9, blob.now() + gap, moments);
    EXPECT_EQ(blob.motion.velocity().x, 0);
    EXPECT_EQ(blob.motion.position_at(blob.now() + gap).x, 7);
  }
  for (const std::int64_t gap : {std::int64_t{990'000}, std::int64_t{-900'000}}) {
    Blob blob(kUnixTime_us, 300, 0);
    blob.move_for(400'000);
    const double vx = blob.motion.velocity().x;
    blob.motion.take(7, 9, blob.now() + gap, blob.moments);
    EXPECT_EQ(blob.motion.velocity().x, vx);
  }
}

TEST(ClusterMotion, AMillionEventsOnOneStampAreOneMeasurement) {
  WindowMoments moments;
  ClusterMotion motion;
  motion.begin({65'000, 65'000}, 0);
  for (int i = 0; i < 1'000'000; ++i) {
    moments.add(65'000, 65'000, 500);
    motion.take(65'000, 65'000, 500, moments);
  }
  for (int i = 0; i < 2'000'000; ++i) motion.take(65'000, 65'000, 1500, moments);
  EXPECT_NEAR(motion.position_at(1500).x, 65'000, 0.1);
  EXPECT_NEAR(motion.velocity().x, 0, 1);
}

TEST(ClusterMotion, SurvivesAnyStamps) {
  std::mt19937_64 random(1);
  WindowMoments moments;
  ClusterMotion motion;
  motion.begin({1, 1}, std::numeric_limits<std::int64_t>::max());
  for (int i = 0; i < 10'000; ++i) {
    // Of all magnitudes.
    const auto t = static_cast<std::int64_t>(random() >> (random() % 64));
    moments.add(random() % 346, random() % 260, t);
    motion.take(random() % 346, random() % 260, t, moments);
    const Vector2 position = motion.position_at(static_cast<std::int64_t>(random()));
    ASSERT_TRUE(std::isfinite(position.x) && std::isfinite(position.y));
    ASSERT_TRUE(std::isfinite(motion.velocity().x) && std::isfinite(motion.velocity().y));
  }
}

}  // namespace
}  // namespace cluster_motion_test
