#include "study/scenes/texture.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace asap::texture_test {
namespace {

TEST(Texture, IsBilinearBetweenLatticePointsAndRepeats) {
  const Texture texture{CounterRandom{5}, 4.0, 0.2, 0.8};
  const double corner = texture.at({8.0, 12.0});
  const double right = texture.at({12.0, 12.0});
  EXPECT_NEAR(texture.at({9.0, 12.0}), 0.75 * corner + 0.25 * right, 1e-12);
  EXPECT_NEAR(texture.at({8.0 - 4 * 64.0, 12.0 + 4 * 64.0}), corner, 1e-12);
  EXPECT_NEAR(texture.at({-1e-9, -1e-9}), texture.at({0.0, 0.0}), 1e-6);
}

TEST(Texture, StaysInItsRangeAndFillsIt) {
  const Texture texture{CounterRandom{5}, 1.0, 0.2, 0.8};
  double least = 1.0;
  double most = 0.0;
  for (double x = 0.0; x < 64.0; x += 1.0) {
    for (double y = 0.0; y < 64.0; y += 1.0) {
      least = std::min(least, texture.at({x, y}));
      most = std::max(most, texture.at({x, y}));
    }
  }
  EXPECT_GE(least, 0.2);
  EXPECT_LT(least, 0.21);
  EXPECT_LE(most, 0.8);
  EXPECT_GT(most, 0.79);
}

TEST(Texture, RefusesABadRange) {
  EXPECT_THROW(Texture(CounterRandom{1}, 0.0, 0.1, 0.9), std::invalid_argument);
  EXPECT_THROW(Texture(CounterRandom{1}, 4.0, 0.9, 0.1), std::invalid_argument);
}

TEST(MovingGround, ShowsAtAPixelWhatHasMovedThere) {
  MovingGround ground{
      {.shift_px_s{40.0, -20.0}, .turn_rad_s = 0.5, .zoom_per_s = 0.3}, 101, 81, CounterRandom{9}};
  const PlanePoint start{30.0, 60.0};
  const double shown = ground.brightness(30, 60);
  for (int step = 0; step < 1000; ++step) ground.advance(250);
  const PlanePoint now = ground.moved(start);
  EXPECT_GT(std::abs(now.x - start.x), 5.0);
  // Between the four pixels around it, as far as the pattern is linear there.
  const auto x = static_cast<std::int32_t>(std::floor(now.x));
  const auto y = static_cast<std::int32_t>(std::floor(now.y));
  const double right = now.x - x;
  const double low = now.y - y;
  const double above =
      ground.brightness(x, y) * (1.0 - right) + ground.brightness(x + 1, y) * right;
  const double below =
      ground.brightness(x, y + 1) * (1.0 - right) + ground.brightness(x + 1, y + 1) * right;
  EXPECT_NEAR(above * (1.0 - low) + below * low, shown, 0.02);
}

TEST(MovingGround, TurnsAndZoomsAboutTheMiddle) {
  MovingGround ground{{.turn_rad_s = 1.0, .zoom_per_s = 1.0}, 101, 81, CounterRandom{9}};
  const double middle = ground.brightness(50, 40);
  ground.advance(100'000);
  EXPECT_DOUBLE_EQ(ground.brightness(50, 40), middle);
  const PlanePoint moved = ground.moved({60.0, 40.0});
  EXPECT_NEAR(moved.x, 50.0 + 11.0 * std::cos(0.1), 1e-2);
  EXPECT_NEAR(moved.y, 40.0 + 11.0 * std::sin(0.1), 1e-2);
}

TEST(MovingGround, RefusesABadMotion) {
  const auto make = [](const MovingGroundConfig& config) {
    return MovingGround(config, 100, 100, CounterRandom{1});
  };
  EXPECT_THROW(make({.shift_px_s{3000.0, 0.0}}), std::invalid_argument);
  EXPECT_THROW(make({.turn_rad_s = std::nan("")}), std::invalid_argument);
  EXPECT_THROW(make({.zoom_per_s = -0.1}), std::invalid_argument);
}

}  // namespace
}  // namespace asap::texture_test
