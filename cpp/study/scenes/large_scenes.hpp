// The scenes H to K, on which the small rigid shapes of A to G say nothing: objects as large as the
// distances between them, thin, hollow, textured or deformable ones, and a camera that moves. Shape
// i is dark if i is even, bright if odd; 1 Hz/px of noise. Functions of their arguments alone.
#pragma once

#include <cstdint>
#include <span>

#include "study/scenes/moving_shapes.hpp"

namespace asap::scenes {

// H: six shapes, of these kinds in turn (bar, angle, ring), 60 to 400 px/s, turning.
MovingShapesConfig large_shapes(std::span<const ShapeKind> kinds, std::uint64_t seed);

// I: six disks of radius 14 to 34 px, plain and textured.
MovingShapesConfig large_disks(std::uint64_t seed);

// J: two hands: a palm of 55 px with five waving fingers each, 50 to 200 px/s.
MovingShapesConfig hands(std::uint64_t seed);

// K: two or three movers of 10 to 40 px before a textured ground, while the camera turns, zooms and
// shifts.
MovingShapesConfig moving_camera(std::uint64_t seed);

}  // namespace asap::scenes
