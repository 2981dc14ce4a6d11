// TrackedObject: one thing that an algorithm follows, at the moment of the question. Plain data, on
// any thread, no allocation; the Python array of objects has these fields in this order.
//
//   for (const TrackedObject& object : tracker.objects()) avoid(object.x, object.y);
#pragma once

#include <cstdint>

namespace asap::inline v0_1 {

struct TrackedObject {
  std::int64_t id;          // never changes, and outlives stops and short occlusions
  double x;                 // px, centre
  double y;                 // px
  double vx;                // px/s
  double vy;                // px/s
  double left;              // px, box
  double top;               // px
  double width;             // px
  double height;            // px
  std::int64_t size;        // live events
  std::int64_t t_last;      // us, timestamp of its newest event
  std::int64_t age_us;      // us, since it began
  double independent = -1;  // 0 to 1, whether it moves unlike the background; -1: not known
};

}  // namespace asap::inline v0_1
