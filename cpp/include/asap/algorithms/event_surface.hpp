// EventSurface: a surface that every event changes around its pixel, by a rule:
// ThresholdOrdinalSurface and SpeedInvariantTimeSurface are EventSurface of their rule. Blind to
// stamps and polarity: what counts is the order of the events. One thread at a time. O(1) per
// event; no allocation after construction.
//
// A rule has a Config, which its constructor checks; frame(); plane(); update(event), for every
// event in the frame, noexcept.
#pragma once

#include <cstdint>
#include <span>

#include "asap/algorithms/padded_plane.hpp"
#include "asap/algorithms/sensor_frame.hpp"
#include "asap/core/check.hpp"
#include "asap/core/event.hpp"

namespace asap {

template <class Rule>
class EventSurface {
 public:
  using Config = typename Rule::Config;
  using Value = typename Rule::Value;

  // Throws std::invalid_argument that names the bad field.
  explicit EventSurface(const Config& config) : config_(config), rule_(config) {}

  // Events outside the frame are dropped and counted.
  void process(EventSpan events) noexcept {
    for (const Event& event : events) {
      if (!rule_.frame().contains(event)) [[unlikely]] {
        ++rejected_;
        continue;
      }
      rule_.update(event);
    }
  }

  // x < width, y < height.
  Value at(std::uint32_t x, std::uint32_t y) const noexcept { return rule_.plane().at(x, y); }

  // The surface row by row. Throws std::invalid_argument unless out.size() is width x height.
  void copy_to(std::span<Value> out) const { rule_.plane().copy_to(out); }

  // The fraction of the events that reaches the surface, in [0, 1]. Checked, without effect: the
  // published rules age by the events of the neighbourhood and hold no rate to correct.
  void set_keep(double gamma) {
    require(0 <= gamma && gamma <= 1, "gamma", gamma, "must be in [0, 1]");
  }

  // Back to the state after construction.
  void reset() noexcept {
    rule_.plane().clear();
    rejected_ = 0;
  }

  // Events dropped because they lie outside the frame.
  std::uint64_t rejected() const noexcept { return rejected_; }

  const Config& config() const noexcept { return config_; }

 private:
  Config config_;
  Rule rule_;
  std::uint64_t rejected_ = 0;
};

}  // namespace asap
