#include "asap/schemes/scheme.hpp"

#include <gtest/gtest.h>

#include "asap/schemes/asap2020.hpp"
#include "asap/schemes/asap2022.hpp"
#include "asap/schemes/dead_beat.hpp"
#include "asap/schemes/deadline.hpp"
#include "asap/schemes/fixed.hpp"
#include "asap/schemes/greedy.hpp"
#include "support/allocation_counter.hpp"

namespace asap::scheme_test {
namespace {

template <class Scheme>
void needs_memory() {
  EXPECT_GE(test::allocations_until_made([] { return make_scheme<Scheme>(); }), 1);
}

TEST(MakeScheme, WhereverMemoryEndsItHasTakenNothing) {
  needs_memory<Asap2020>();
  needs_memory<Asap2022>();
  needs_memory<DeadBeat>();
  needs_memory<Deadline>();
  needs_memory<FixedSize>();
  needs_memory<FixedTime>();
  needs_memory<Greedy>();
  needs_memory<SingleEvent>();
}

}  // namespace
}  // namespace asap::scheme_test
