// The scenes H to O, on which the small rigid shapes of A to G say nothing: objects as large as the
// distances between them, thin, hollow, textured or deformable ones, a camera that moves; and what
// recordings show: sparse objects, one that comes near, lamps and hot pixels, a fence. Object i is
// dark if i is even, bright if odd; 1 Hz/px of noise but in L. Functions of their arguments alone.
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

// L: three movers of 40 to 130 px whose contrast is little above the thresholds, so that each fires
// 2 to 10 kev/s; 0.1 to 0.5 Hz/px of noise.
MovingShapesConfig sparse(std::uint64_t seed);

// M: a disk or a square, the last object, that grows from 10 to 100 px in 1 to 1.8 s, before two or
// three small ones.
MovingShapesConfig approaching(std::uint64_t seed);

// N: four small movers; the rest is noise: lamps of 50, 100 and 1000 Hz, 6 to 16 px, and two pairs
// of hot pixels of 1000 events per second each.
MovingShapesConfig lamps(std::uint64_t seed);

// O: a ball of radius 15 to 40 px behind a fence: wires of 3 to 6 px every 10 to 20 px, vertical,
// diagonal or both diagonals.
MovingShapesConfig fence(std::uint64_t seed);

}  // namespace asap::scenes
