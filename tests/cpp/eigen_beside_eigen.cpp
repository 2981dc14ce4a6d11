// The library's Eigen beside that of a user whose file is compiled for another processor: no symbol
// of the one stands for one of the other, whichever the linker meets first.
#include <chrono>
#include <cmath>
#include <cstdio>

#include "asap/algorithms/motion_segmenter.hpp"
#include "asap/synthetic/streams.hpp"

double users_gain();

int main() {
  using namespace std::chrono_literals;
  const double users = users_gain();
  asap::ShakenPattern scene{{.duration = 300ms}};
  asap::MotionSegmenter segmenter{{.width = 346, .height = 260}};
  std::size_t known = 0;
  for (auto events = scene.next(); !events.empty(); events = scene.next()) {
    segmenter.process(events);
    if (segmenter.camera_motion()) ++known;
  }
  std::printf("user's gain %g, camera motion known %zu times\n", users, known);
  return std::abs(users - 8.0 / 3.0) < 1e-12 && known > 0 ? 0 : 1;
}
