#include "algorithms/newest_patch.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <vector>

#include "algorithms/corner_streams.hpp"
#include "algorithms/order_surface.hpp"

namespace asap::newest_patch_test {
namespace {

// Every window of a stream on both paths: the same patches, so the same scores and labels. On a
// machine without AVX2 both are the portable one.
void expect_the_same_patches(const SensorFrame& frame, const std::vector<Event>& events) {
  OrderSurface surface(frame);
  NewestPatch fastest(NewestPatch::Path::fastest);
  NewestPatch portable(NewestPatch::Path::portable);
  for (std::size_t i = 0; i < events.size(); ++i) {
    OrderSurface::Number* pixel = surface.pixel(events[i]);
    *pixel = surface.next();
    if (!frame.contains(events[i], 4)) continue;
    PatchRows a, b;
    const bool found = portable.select(pixel, surface.stride(), b);
    ASSERT_EQ(fastest.select(pixel, surface.stride(), a), found) << i;
    if (found) {
      ASSERT_EQ(a, b) << i;
    }
  }
}

TEST(NewestPatch, TheFastPathAgreesWithThePortableOne) {
  const SensorFrame frame(346, 260);
  expect_the_same_patches(frame, test::golden_corner_stream());
  expect_the_same_patches(frame, test::turning_shapes({.speed = 700}, 100'000));
  expect_the_same_patches(frame, test::turning_shapes({.speed = 300, .noise_hz = 8}, 100'000));
  for (const auto& wild : test::wild_streams()) {
    expect_the_same_patches(SensorFrame(wild.width, wild.height), test::wild_stream(wild, 6000));
  }
}

}  // namespace
}  // namespace asap::newest_patch_test
