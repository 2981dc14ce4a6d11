#include "asap/schemes/reservoir_price.hpp"

#include <gtest/gtest.h>

namespace asap::reservoir_price_test {
namespace {

constexpr double kBound = 100.0;

TEST(ReservoirPrice, FallsWithWhatIsPaidUntilHalfABound) {
  ReservoirPrice price;
  EXPECT_EQ(price.share(kBound), 1.0);
  price.pay(10);
  EXPECT_DOUBLE_EQ(price.share(kBound), 0.8);
  price.pay(40);
  EXPECT_EQ(price.share(kBound), 0.0);
  price.pay(1e9);
  EXPECT_EQ(price.share(kBound), 0.0);
}

TEST(ReservoirPrice, StartsAnOverloadWithWhatTheyUsuallyCost) {
  ReservoirPrice price;
  price.pay(20);
  price.settle();
  EXPECT_DOUBLE_EQ(price.share(kBound), 0.6);  // one overload, 20
  price.pay(5);
  EXPECT_DOUBLE_EQ(price.share(kBound), 0.6);  // this one is cheap so far
  price.pay(25);
  EXPECT_DOUBLE_EQ(price.share(kBound), 0.4);  // and now dearer than usual
  price.settle();
  EXPECT_DOUBLE_EQ(price.share(kBound), 1.0 - (0.9 * 20 + 30) / 1.9 / 50);
}

TEST(ReservoirPrice, ForgetsWhatIsLongPast) {
  ReservoirPrice price;
  price.pay(1000);
  price.settle();
  EXPECT_EQ(price.share(kBound), 0.0);
  for (int k = 0; k < 60; ++k) {
    price.pay(1);
    price.settle();
  }
  EXPECT_NEAR(price.share(kBound), 0.98, 0.005);
}

TEST(ReservoirPrice, AnOverloadThatCostNothingIsNone) {
  ReservoirPrice price;
  price.pay(20);
  price.settle();
  price.settle();
  EXPECT_DOUBLE_EQ(price.share(kBound), 0.6);
}

}  // namespace
}  // namespace asap::reservoir_price_test
