#include "packager/kept_mask.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "support/allocation_counter.hpp"
#include "support/streams.hpp"

namespace asap::kept_mask_test {
namespace {

using test::at_times;
using test::evenly_spaced;
using test::Events;

using Mask = std::vector<std::uint8_t>;
using First = std::vector<std::int64_t>;

// All of these were let through and found room.
void enter(KeptMask& mask, std::size_t count) {
  mask.passed().append(count, true);
  mask.entered(count, 0);
}

TEST(KeptMask, IsEmptyForNothing) {
  const KeptEvents reading = KeptMask().read();
  EXPECT_TRUE(reading.kept.empty());
  EXPECT_TRUE(reading.first.empty());
}

TEST(KeptMask, LeadsBackPastWhatWasRejectedAndWhatFoundNoRoom) {
  KeptMask mask;
  for (const bool passed : {true, false, true, true, false, true}) mask.passed().append(passed);
  mask.entered(1, 1);  // number 2 finds the ring full
  mask.entered(2, 0);
  const Events raw = at_times({0, 3, 5});
  mask.packaged({raw, {}}, 3, EventSpan(raw).subspan(1, 1));
  EXPECT_EQ(mask.read().kept, (Mask{0, 0, 0, 1, 0, 0}));
  EXPECT_EQ(mask.read().first, (First{0}));
}

TEST(KeptMask, FindsTheKeptEventsAcrossTheWrap) {
  KeptMask mask;
  enter(mask, 6);
  const Events raw = evenly_spaced(6, 10);
  const Events kept = {raw[1], raw[3], raw[4]};
  mask.packaged({EventSpan(raw).first(2), EventSpan(raw).subspan(2)}, 5, kept);
  EXPECT_EQ(mask.read().kept, (Mask{0, 1, 0, 1, 1, 0}));  // the sixth stays in the ring
}

TEST(KeptMask, TakesTheFirstOfEqualEvents) {
  KeptMask mask;
  enter(mask, 3);
  const Events raw(3, Event{1, 2, 1, 7});
  mask.packaged({raw, {}}, 3, EventSpan(raw).first(2));
  EXPECT_EQ(mask.read().kept, (Mask{1, 1, 0}));
}

TEST(KeptMask, TellsWherePackagesBegin) {
  KeptMask mask;
  mask.passed().append(false);  // every number is one more than in the ring
  enter(mask, 10);
  const Events raw = evenly_spaced(10, 10);
  const auto part = [&](std::size_t begin, std::size_t count) {
    return EventPieces{EventSpan(raw).subspan(begin, count), {}};
  };
  mask.packaged(part(0, 2), 2, EventSpan(raw).first(1));
  mask.passed_over(1);
  mask.packaged(part(3, 2), 2, {});  // kept nothing: counts to the next package
  mask.passed_over(1);
  mask.packaged(part(6, 2), 2, EventSpan(raw).subspan(7, 1));
  mask.packaged(part(8, 1), 1, EventSpan(raw).subspan(8, 1));
  EXPECT_EQ(mask.read().first, (First{1, 4, 9}));
  EXPECT_EQ(mask.read().kept, (Mask{0, 1, 0, 0, 0, 0, 0, 0, 1, 1, 0}));
}

TEST(KeptMask, DoesNotAllocateWhereRoomWasMade) {
  KeptMask mask;
  const Events raw = evenly_spaced(1000, 1);
  mask.make_room(3000);
  const std::size_t before = test::allocations();
  mask.passed_over(1500);
  mask.packaged({raw, {}}, 1000, EventSpan(raw).first(10));
  EXPECT_EQ(test::allocations(), before);
}

}  // namespace
}  // namespace asap::kept_mask_test
