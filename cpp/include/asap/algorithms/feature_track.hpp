// FeatureTrack: what FeatureTracker says about one corner that it follows, at the moment of the
// question. Plain data; the Python array of tracks has these fields in this order.
#pragma once

#include <cstdint>

namespace asap {

struct FeatureTrack {
  std::int64_t id;       // never changes while the track lives
  double x;              // px, of its newest event
  double y;              // px
  double vx;             // px/s
  double vy;             // px/s
  std::int64_t size;     // corner events it took
  std::int64_t t_first;  // us, stamp of the first of them
  std::int64_t t_last;   // us, of the newest
};

}  // namespace asap
