// harris_score: the Harris score of a 9 x 9 patch of black and white pixels: 5 x 5 gradients by a
// kernel of 5 x 5, weighted by a Gaussian. Integers but for the last sums, so the same bits on
// every platform. Pure function, no allocation. Source: Vasco, Glover, Bartolozzi, "Fast
// Event-based Harris Corner Detection Exploiting the Advantages of Event-driven Cameras", IROS
// 2016.
#pragma once

#include "algorithms/newest_patch.hpp"

namespace asap::inline v0_1 {

double harris_score(const PatchRows& rows) noexcept;

// A threshold of the score. Throws std::invalid_argument that names it, unless it is finite.
double checked_threshold(double threshold);

}  // namespace asap::inline v0_1
