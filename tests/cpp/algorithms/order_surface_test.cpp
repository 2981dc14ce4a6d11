#include "algorithms/order_surface.hpp"

#include <gtest/gtest.h>

#include <cstdint>

#include "core/random.hpp"

namespace order_surface_test {
namespace {

using asap::Event;
using asap::OrderSurface;
using asap::SensorFrame;

Event at(std::uint16_t x, std::uint16_t y, int p = 0) {
  return {.x = x, .y = y, .p = static_cast<std::int16_t>(p), .t = 0};
}

// Two surfaces beside each other, one of which renumbers every few events.
template <class Next>
void expect_same_order(Next next) {
  constexpr int kSide = 3;
  const SensorFrame frame(kSide, kSide);
  OrderSurface wide(frame);
  OrderSurface tight(frame, 25);
  const asap::CounterRandom random(1);
  for (std::uint64_t i = 0; i < 2000; ++i) {
    const std::uint64_t bits = random(i);
    const Event event = at(static_cast<std::uint16_t>(bits % 3),
                           static_cast<std::uint16_t>((bits >> 8) % 3), (bits >> 16) & 1 ? 1 : 0);
    const auto stamp = static_cast<std::int64_t>(i / 3);
    const auto number = next(tight, stamp);  // first: it may renumber the pixels
    *tight.pixel(event) = number;
    *wide.pixel(event) = next(wide, stamp);
    ASSERT_LT(number, 25);
    for (std::uint16_t a = 0; a < 2 * kSide * kSide; ++a) {
      for (std::uint16_t b = 0; b < a; ++b) {
        const auto pixel = [](OrderSurface& surface, std::uint16_t n) {
          return *surface.pixel(at(static_cast<std::uint16_t>(n % kSide),
                                   static_cast<std::uint16_t>(n / kSide % kSide),
                                   n / (kSide * kSide)));
        };
        ASSERT_EQ(pixel(tight, a) <=> pixel(tight, b), pixel(wide, a) <=> pixel(wide, b));
        ASSERT_EQ(pixel(tight, a) == 0, pixel(wide, a) == 0);
      }
    }
  }
}

TEST(OrderSurface, RenumberingKeepsTheOrderOfEvents) {
  expect_same_order([](OrderSurface& surface, std::int64_t) { return surface.next(); });
}

TEST(OrderSurface, RenumberingKeepsTheOrderOfStamps) {
  expect_same_order([](OrderSurface& surface, std::int64_t t) { return surface.next(t); });
}

}  // namespace
}  // namespace order_surface_test
