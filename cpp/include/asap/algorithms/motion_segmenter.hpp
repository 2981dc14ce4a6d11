// MotionSegmenter: what moves on its own before a moving camera. Every 10 ms the normal flow of the
// last 15 ms (PlaneFlow) gives the motion of the background, with four parameters, robustly. Cells
// whose flow needs a shift beside it are flagged; connected ones are a region, and regions are
// followed. Where the flow does not cover the frame, mostly before a camera at rest, the answer is
// "unknown". Depth and motion are not separated: a thing much nearer than the background moves
// unlike it. One thread at a time. O(1) per event,
// O(flow events of 15 ms + cells) per 10 ms; allocates in the constructor only. A timestamp that
// goes back by up to 1 s counts as the latest one. Results do not depend on how the stream is cut.
// Source: own design; the residual of a global motion as in Vasco et al., "Independent Motion
// Detection with Event-driven Cameras", ICAR 2017, which has corners instead of flow.
//
//   MotionSegmenter segmenter{{.width = 346, .height = 260}};
//   segmenter.process(events);
//   for (const TrackedObject& object : segmenter.objects()) draw(object.id, object.x, object.y);
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "asap/algorithms/cluster_tracker.hpp"
#include "asap/core/event.hpp"

namespace asap::inline v0_1 {

struct MotionSegmenterConfig {
  int width;   // px
  int height;  // px
  // That of PlaneFlow: edges must cover some 3 px in it, of slower ones the flow is too fast.
  std::chrono::microseconds window{60000};
  double min_px_s = 40;    // least speed against the background, and ...
  double min_share = 0.5;  // ... this share of the background's own speed
};

// The background at (x, y) moves with vx - turn (y - cy) + zoom (x - cx) and
// vy + turn (x - cx) + zoom (y - cy); (cx, cy) is the middle of the frame.
struct CameraMotion {
  std::int64_t t;  // us, the time for which it holds
  double vx;       // px/s, of the background at the middle of the frame
  double vy;       // px/s
  double turn;     // rad/s, from x (to the right) towards y (downwards)
  double zoom;     // 1/s, growth of the picture
  std::array<std::array<double, 4>, 4> covariance;  // of the error of vx, vy, turn, zoom
};

class MotionSegmenter {
 public:
  using Config = MotionSegmenterConfig;

  // Throws std::invalid_argument that names the bad field.
  explicit MotionSegmenter(const Config& config);
  ~MotionSegmenter();
  MotionSegmenter(MotionSegmenter&& other) noexcept;
  MotionSegmenter& operator=(MotionSegmenter&& other) noexcept;

  // Events outside the frame are dropped and counted.
  void process(EventSpan events) noexcept;

  // What moves unlike the background, sorted by id, positions predicted for the latest event.
  // `independent` is 1; -1 while the background's motion is unknown, in which time the objects of
  // before go on for 20 ms.
  std::vector<TrackedObject> objects() const;

  // The same without allocation once `objects` has the capacity.
  void objects(std::vector<TrackedObject>& objects) const;

  // What `objects` would be at t_us if nothing came until then; a t_us of the past counts as the
  // latest time.
  std::vector<TrackedObject> objects_at(std::int64_t t_us) const;
  void objects_at(std::int64_t t_us, std::vector<TrackedObject>& objects) const;

  // Empty: unknown.
  std::optional<CameraMotion> camera_motion() const noexcept;

  // Sets the fraction of the events that reaches the algorithm, in [0, 1]: the flow that "known"
  // asks for goes with it. Throws std::invalid_argument if gamma is out of range.
  void set_gamma(double gamma);

  // Back to the state after construction.
  void reset() noexcept;

  // Events dropped because they lie outside the frame.
  std::uint64_t rejected() const noexcept;

  const Config& config() const noexcept;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace asap::inline v0_1
