#include "algorithms/newest_patch_avx2.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "algorithms/corner_streams.hpp"
#include "algorithms/order_surface.hpp"

namespace newest_patch_avx2_test {
namespace {

using asap::Event;
using asap::NewestPatch;
using asap::OrderSurface;
using asap::PatchRows;
using asap::PatchSearch;

// Every window of a stream on both paths: the same patches, so the same scores and labels.
void expect_the_same_patches(const asap::SensorFrame& frame, const std::vector<Event>& events) {
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

TEST(NewestPatchAvx2, AgreesWithThePortablePath) {
  const asap::SensorFrame frame(346, 260);
  expect_the_same_patches(frame, asap::test::golden_corner_stream());
  expect_the_same_patches(frame, asap::test::turning_shapes({.speed = 700}, 100'000));
  expect_the_same_patches(frame,
                          asap::test::turning_shapes({.speed = 300, .noise_hz = 8}, 100'000));
  for (const auto& wild : asap::test::wild_streams()) {
    expect_the_same_patches(asap::SensorFrame(wild.width, wild.height),
                            asap::test::wild_stream(wild, 6000));
  }
}

class Window {
 public:
  Window() { numbers_.fill(OrderSurface::kNever); }
  OrderSurface::Number& operator()(std::size_t x, std::size_t y) { return numbers_[9 * y + x]; }
  PatchSearch select(OrderSurface::Number depth, PatchRows& rows) {
    return asap::select_avx2(&numbers_[40], 9, depth, rows);
  }

 private:
  std::array<OrderSurface::Number, 81> numbers_;
};

// Each pixel alone among the newest, and each alone among the oldest.
TEST(NewestPatchAvx2, FindsEveryPixelInItsPlace) {
  if (!asap::has_avx2()) GTEST_SKIP() << "this machine has no AVX2";
  for (std::size_t place = 0; place < 81; ++place) {
    if (place == 40) continue;
    Window window;
    OrderSurface::Number number = 1000;
    PatchRows expected{};
    expected[4] = 1U << 4;
    const auto fire = [&](std::size_t i) { window(i % 9, i / 9) = number--; };
    fire(40);
    std::size_t picked = 1;
    for (std::size_t i = place; picked < 25; i = (i + 1) % 81) {
      if (i == 40) continue;
      fire(i);
      expected[i / 9] |= 1U << (i % 9);
      ++picked;
    }
    for (std::size_t i = 0; i < 81; ++i) {
      if (window(i % 9, i / 9) == OrderSurface::kNever) fire(i);
    }
    PatchRows rows;
    ASSERT_EQ(window.select(64, rows), PatchSearch::found) << place;
    ASSERT_EQ(rows, expected) << place;
  }
}

TEST(NewestPatchAvx2, LeavesToThePortablePathWhatItCannotTell) {
  if (!asap::has_avx2()) GTEST_SKIP() << "this machine has no AVX2";
  Window window;
  for (std::size_t i = 0; i < 81; ++i) {
    window(i % 9, i / 9) = 1'000'000'000 - static_cast<OrderSurface::Number>(i);
  }
  window(4, 4) = 2'000'000'000;
  PatchRows rows;
  EXPECT_EQ(window.select(64, rows), PatchSearch::unresolved);             // far below the guess
  EXPECT_EQ(window.select(1'000'000'000, rows), PatchSearch::unresolved);  // too close together
  for (std::size_t i = 0; i < 36; ++i) window(i % 9, i / 9) = OrderSurface::kNever;
  for (std::size_t i = 60; i < 81; ++i) window(i % 9, i / 9) = OrderSurface::kNever;
  EXPECT_EQ(window.select(64, rows), PatchSearch::too_few);  // 24 have fired
  EXPECT_EQ(window.select(1'000'000'000, rows), PatchSearch::too_few);
}

}  // namespace
}  // namespace newest_patch_avx2_test
