// The rule by which tests of what lies behind the gate let events through it.
#pragma once

#include "algorithms/fast/gate.hpp"

namespace asap::fast {

inline constexpr GateRule kGate{.birth_radius_px = 18,
                                .min_radius_px = 7,
                                .max_radius_px = 40,
                                .scale = 2.3F,
                                .padding_px = 2,
                                .circle_scale = 2.2F,
                                .circle_padding_px = 5};

}  // namespace asap::fast
