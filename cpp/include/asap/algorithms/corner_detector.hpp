// CornerDetector: labels each event of a stream as corner or not, by a rule: EFast, ArcStar,
// EHarris and FAHarris are CornerDetector of their rule. One thread at a time. O(1) per event; no
// allocation after construction. Stamps that go back count as the latest one.
//
// A rule has a Config, which its constructor checks; frame(); is_corner(event), for every event in
// the frame, noexcept; and clear().
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "asap/algorithms/sensor_frame.hpp"
#include "asap/core/check.hpp"
#include "asap/core/event.hpp"

namespace asap {

template <class Rule>
class CornerDetector {
 public:
  using Config = typename Rule::Config;

  // Throws std::invalid_argument that names the bad field.
  explicit CornerDetector(const Config& config) : config_(config), rule_(config) {}

  // Returns how many of the events are corners. Events outside the frame are dropped and counted.
  std::size_t process(EventSpan events) noexcept {
    std::size_t corners = 0;
    for (const Event& event : events) corners += update(event);
    return corners;
  }

  // As above, and corners[i] is 1 where events[i] is a corner, else 0. Throws std::invalid_argument
  // if the sizes differ.
  void process(EventSpan events, std::span<std::uint8_t> corners) {
    require(corners.size() == events.size(), "corners.size()", corners.size(),
            "must be the number of events");
    for (std::size_t i = 0; i < events.size(); ++i) corners[i] = update(events[i]);
  }

  // The fraction of the events that reaches the detector, in [0, 1]. Checked, without effect: the
  // published rules compare the order of events and hold no rate to correct.
  void set_keep(double gamma) {
    require(0 <= gamma && gamma <= 1, "gamma", gamma, "must be in [0, 1]");
  }

  // Back to the state after construction.
  void reset() noexcept {
    rule_.clear();
    rejected_ = 0;
  }

  // Events dropped because they lie outside the frame.
  std::uint64_t rejected() const noexcept { return rejected_; }

  const Config& config() const noexcept { return config_; }

 private:
  bool update(const Event& event) noexcept {
    if (!rule_.frame().contains(event)) [[unlikely]] {
      ++rejected_;
      return false;
    }
    return rule_.is_corner(event);
  }

  Config config_;
  Rule rule_;
  std::uint64_t rejected_ = 0;
};

}  // namespace asap
