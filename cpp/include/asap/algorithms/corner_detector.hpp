// CornerDetector: labels each event of a stream as corner or not, by one of four published rules:
// EFast, ArcStar, EHarris and FAHarris. All rules compare only events of one polarity. One thread
// at a time. O(1) per event; no allocation after construction. A timestamp that goes back by up to
// 1 s counts as the latest one.
//
//   EFast detector{{.width = 346, .height = 260}};
//   std::vector<std::uint8_t> corners(events.size());
//   detector.process(events, std::span(corners));  // 1 where the event is a corner
#pragma once

#include <chrono>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "asap/core/event.hpp"

namespace asap::inline v0_1 {

struct EFastConfig {
  int width;   // px
  int height;  // px
};

struct ArcStarConfig {
  int width;   // px
  int height;  // px
  // An event is tested if its pixel was silent for longer in its polarity, or fired in the other
  // since: the first of the burst that an edge makes. A quarter of the events are.
  std::chrono::microseconds filter{50000};
};

struct EHarrisConfig {
  int width;             // px
  int height;            // px
  double threshold = 8;  // a corner has a greater score
};

struct FAHarrisConfig {
  int width;                                // px
  int height;                               // px
  std::chrono::microseconds filter{50000};  // see ArcStarConfig
  double threshold = 8;                     // a corner has a greater score
};

template <class Rule, class Configuration>
class CornerDetector {
 public:
  using Config = Configuration;
  using Answer = std::uint8_t;

  // Rows around an event that its label depends on: FAHarris ignores those 4 px from the border.
  static constexpr int reach(const Config&) noexcept {
    return std::same_as<Config, FAHarrisConfig> ? 8 : 4;
  }

  // Throws std::invalid_argument that names the bad field.
  explicit CornerDetector(const Config& config);
  ~CornerDetector();
  CornerDetector(CornerDetector&& other) noexcept;
  CornerDetector& operator=(CornerDetector&& other) noexcept;

  // Returns how many of the events are corners. Events outside the frame are dropped and counted.
  std::size_t process(EventSpan events) noexcept;

  // Takes the events, and corners[i] is 1 where events[i] is a corner, else 0. Throws
  // std::invalid_argument if the sizes differ.
  void process(EventSpan events, std::span<std::uint8_t> corners);
  // As Tiled deals them: corners[places[i]] is the label of events[i], if there is such a place.
  void process(EventSpan events, std::span<std::uint8_t> corners,
               const std::uint32_t* places) noexcept;

  // The fraction of the events that reaches the detector, in [0, 1]. Checked, without effect: the
  // published rules compare the order of events and hold no rate to correct.
  void set_gamma(double gamma);

  // Back to the state after construction.
  void reset() noexcept;

  // Events dropped because they lie outside the frame.
  std::uint64_t rejected() const noexcept { return rejected_; }

  const Config& config() const noexcept { return config_; }

 private:
  Config config_;
  std::unique_ptr<Rule> rule_;
  std::uint64_t rejected_ = 0;
};

// EFast looks at order alone: an event is a corner if on a circle of 16 pixels around it 3 to 6
// neighbouring ones fired later than all others, and 4 to 8 on a circle of 20. Source: Mueggler,
// Bartolozzi, Scaramuzza, "Fast Event-based Corner Detection", BMVC 2017. The authors' release
// swaps width and height of its surface; here they are as published.
class EFastRule;
extern template class CornerDetector<EFastRule, EFastConfig>;
using EFast = CornerDetector<EFastRule, EFastConfig>;

// ArcStar looks at the length of the newest arc on the same circles, for the first event of a
// burst: 6 pixels at most or 10 to 13 on the circle of 16, 8 at most or 12 to 16 on the one of 20.
// Source: Alzugaray, Chli, "Asynchronous Corner Detection and Tracking for Event Cameras in Real
// Time", RA-L 2018; the length is the one of its release.
class ArcStarRule;
extern template class CornerDetector<ArcStarRule, ArcStarConfig>;
using ArcStar = CornerDetector<ArcStarRule, ArcStarConfig>;

// EHarris scores the 25 pixels around the event that fired last, taken as a black and white
// patch: the event is a corner if the score exceeds the threshold.
// Source: Vasco, Glover, Bartolozzi, "Fast Event-based Harris Corner Detection Exploiting the
// Advantages of Event-driven Cameras", IROS 2016, with the constants of the public implementation.
class EHarrisRule;
extern template class CornerDetector<EHarrisRule, EHarrisConfig>;
using EHarris = CornerDetector<EHarrisRule, EHarrisConfig>;

// FAHarris has two steps: the arcs of Arc* propose, the Harris score decides. Both look only at the
// first event of a burst. Events within 4 px of the border are ignored altogether. Source: Li, Shi,
// Zhang, Li, Liu, "FA-Harris: A Fast and Asynchronous Corner Detector for Event Cameras", IROS
// 2019, with the constants of its release; equal timestamps are ordered by arrival.
class FAHarrisRule;
extern template class CornerDetector<FAHarrisRule, FAHarrisConfig>;
using FAHarris = CornerDetector<FAHarrisRule, FAHarrisConfig>;

}  // namespace asap::inline v0_1
