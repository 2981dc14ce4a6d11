// The rule of the default settings, for tests of pairs of tracks.
#pragma once

#include "algorithms/fast/merge.hpp"

namespace asap::fast {

inline constexpr PairRule kPairs{.birth_radius_px = 18,
                                 .merge_reach = 1.6F,
                                 .merge_padding_px = 8,
                                 .contact_reach = 1.6F,
                                 .contact_padding_px = 1};

}  // namespace asap::fast
