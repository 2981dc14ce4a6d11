// FeatureConfig: parameters of FeatureTracker. w, B and m are those of the published rule, with the
// launch values of its release; the velocity is ours.
// Source: the authors' release of the GRVC event feature tracker (grvc_ef_tracker), which the ASAP
// papers use.
#pragma once

#include <cstdint>

namespace asap {

// Where the corners come from.
enum class CornerSource : std::uint8_t {
  every_event,  // the events handed in are corners
  e_fast,
  arc_star,
  e_harris,
  fa_harris,
};

struct FeatureConfig {
  int width;                                       // px
  int height;                                      // px
  CornerSource detector = CornerSource::arc_star;  // with its defaults
  int window = 200;                                // B, corner events that are remembered
  int radius = 5;                    // px, half of w: how far a corner moves between two events
  int min_neighbours = 1;            // m: a corner needs more than these in the 3 x 3 window
  std::int64_t velocity_us = 20000;  // how far back the velocity looks
};

// The same configuration. Throws std::invalid_argument that names the first bad field.
const FeatureConfig& checked(const FeatureConfig& config);

}  // namespace asap
