#include "synthetic/contrast_pixel.hpp"

#include <gtest/gtest.h>

namespace asap::contrast_pixel_test {
namespace {

using Change = ContrastPixel::Change;

constexpr std::int32_t kStep_us = 250;

// Level and reference at 0.
ContrastPixel pixel(double on = 0.2, double off = 0.3) { return {on, off, 0.0, 0.0}; }

TEST(ContrastPixel, FiresWhenItCrossesAThresholdAtTheInterpolatedTime) {
  auto up = pixel();
  EXPECT_EQ(up.move_to(0.8, 0, kStep_us), (Change{62, true}));  // 0.2 of 0.8: 62.5 us
  auto down = pixel();
  EXPECT_EQ(down.move_to(-0.4, 0, kStep_us), (Change{187, false}));  // 0.3 of 0.4
}

TEST(ContrastPixel, StaysSilentBelowTheThresholdsAndAddsUpWhatItSaw) {
  auto slow = pixel();
  EXPECT_EQ(slow.move_to(0.15, 0, kStep_us), std::nullopt);
  EXPECT_EQ(slow.move_to(-0.25, 250, kStep_us), std::nullopt);
  EXPECT_EQ(slow.move_to(0.15, 500, kStep_us), std::nullopt);
  EXPECT_EQ(slow.move_to(0.25, 750, kStep_us), (Change{125, true}));  // half way up to 0.25
}

TEST(ContrastPixel, IsBlindFor300MicrosecondsButTheReferenceMoves) {
  auto fast = pixel();
  EXPECT_EQ(fast.move_to(0.3, 0, kStep_us), (Change{166, true}));    // at 0.2
  EXPECT_EQ(fast.move_to(0.5, 250, kStep_us), std::nullopt);         // at 0.4: lost at 375
  EXPECT_EQ(fast.move_to(0.5, 500, kStep_us), std::nullopt);         // it was seen
  EXPECT_EQ(fast.move_to(0.7, 750, kStep_us), (Change{125, true}));  // at 0.6
}

TEST(ContrastPixel, SeesAgainAfterExactly300Microseconds) {
  for (const std::int64_t late_us : {0, 1}) {
    auto pixel_in_time = pixel(0.2, 0.2);
    EXPECT_EQ(pixel_in_time.move_to(0.25, 0, kStep_us), (Change{200, true}));  // until 500
    const auto again = pixel_in_time.move_to(0.45, 311 + late_us, kStep_us);
    // The crossing of 0.4 is 187 us into the step: at 498 or 499 us.
    EXPECT_EQ(again, std::nullopt);
    auto pixel_too_late = pixel(0.2, 0.2);
    EXPECT_EQ(pixel_too_late.move_to(0.25, 0, kStep_us), (Change{200, true}));
    EXPECT_EQ(pixel_too_late.move_to(0.45, 313 + late_us, kStep_us), (Change{187, true}));
  }
}

TEST(ContrastPixel, SeveralThresholdsInAStepAreOneEventAndOneNewReference) {
  auto jump = pixel();
  EXPECT_EQ(jump.move_to(1.1, 0, kStep_us), (Change{45, true}));  // the first of five
  EXPECT_EQ(jump.move_to(0.75, 1000, kStep_us), std::nullopt);    // 1.0 - 0.25
  EXPECT_EQ(jump.move_to(0.65, 2000, kStep_us), (Change{125, false}));
}

// The reference lies beyond the level, or already a threshold away from it.
TEST(ContrastPixel, NeverFiresOutsideTheStep) {
  ContrastPixel early{0.1, 0.1, 0.0, -0.12};
  EXPECT_EQ(early.move_to(0.01, 0, kStep_us), (Change{0, true}));
  ContrastPixel late{0.1, 0.1, 0.0, -0.12};
  EXPECT_EQ(late.move_to(-0.01, 0, kStep_us), (Change{249, true}));
  ContrastPixel still{0.1, 0.1, 0.0, -0.12};
  EXPECT_EQ(still.move_to(0.0, 0, kStep_us), (Change{0, true}));
  ContrastPixel end{0.25, 0.25, 0.0, 0.0};
  EXPECT_EQ(end.move_to(0.25, 0, kStep_us), (Change{249, true}));
}

}  // namespace
}  // namespace asap::contrast_pixel_test
