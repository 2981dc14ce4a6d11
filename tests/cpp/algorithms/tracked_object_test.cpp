#include "asap/algorithms/tracked_object.hpp"

#include <gtest/gtest.h>

namespace tracked_object_test {
namespace {

TEST(TrackedObject, IsNotKnownToBeIndependentUnlessSaid) {
  const asap::TrackedObject object{};
  EXPECT_EQ(object.independent, -1);
}

}  // namespace
}  // namespace tracked_object_test
