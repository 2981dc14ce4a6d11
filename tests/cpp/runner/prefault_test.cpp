#include "runner/prefault.hpp"

#include <gtest/gtest.h>

namespace asap::prefault_test {
namespace {

TEST(Prefault, TouchesWithoutHarm) {
  touch_code();
  touch_stack();
}

}  // namespace
}  // namespace asap::prefault_test
