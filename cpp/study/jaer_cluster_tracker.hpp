// JaerClusterTracker: a rival of the cluster tracker, after the core of jAER's
// RectangularClusterTracker: square boxes of 32 px that each event inside draws a little nearer,
// masses that decay, boxes that overlap and move alike become one. A baseline of an experiment, not
// a product. One thread at a time. O(boxes near by) per event, O(boxes^2) per tick of a
// millisecond; allocates in the constructor and for what it returns. Same clock as the cluster
// tracker's: a timestamp that goes back counts as the latest one.
// Source: Delbruck and Lang, "Robotic goalie with 3 ms reaction time at 4 % CPU load using
// event-based dynamic vision sensor", 2013; built from its rules, the Java program was not run.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "algorithms/fast/association.hpp"
#include "algorithms/sensor_frame.hpp"
#include "asap/algorithms/cluster_tracker.hpp"
#include "asap/core/event.hpp"
#include "core/event_clock.hpp"

namespace asap {

struct JaerClusterConfig {
  int width;   // px
  int height;  // px
};

class JaerClusterTracker {
 public:
  using Config = JaerClusterConfig;

  static constexpr std::size_t kBoxes = 64;
  static constexpr float kHalfSide_px = 16;
  static constexpr float kVisibleMass = 10;

  // Throws std::invalid_argument that names the bad field.
  explicit JaerClusterTracker(const Config& config);

  // Events outside the frame are dropped and counted.
  void process(EventSpan events) noexcept;

  // As above, and labels[i] is the id of the box that took events[i]; -1 where it is not visible
  // yet, or all boxes are taken elsewhere. Throws std::invalid_argument if the sizes differ.
  void process(EventSpan events, std::span<std::int32_t> labels);

  // The visible boxes, sorted by id, positions predicted for t_us; a t_us of the past is the latest
  // time. Asking changes nothing.
  std::vector<Cluster> clusters() const { return clusters_at(clock_.latest_us()); }
  std::vector<Cluster> clusters_at(std::int64_t t_us) const;

  // Back to the state after construction.
  void reset() noexcept;

  // Events dropped because they lie outside the frame.
  std::uint64_t rejected() const noexcept { return rejected_; }

  const Config& config() const noexcept { return config_; }

 private:
  using Slot = fast::CoarseIndex::Slot;

  struct Box {
    float x;  // px
    float y;
    float mass;              // at `last_us`
    std::uint64_t last_us;   // its newest event
    std::uint64_t since_us;  // its first
    float vx;                // px/s
    float vy;
    float ticked_x;  // px, at the last tick
    float ticked_y;
    std::int32_t id;
  };

  std::int32_t process(const Event& event) noexcept;
  Slot nearest_around(const Event& event) const noexcept;
  Slot create(float x, float y) noexcept;
  void take(Slot slot, const Event& event) noexcept;

  void tick() noexcept;
  void follow(Box& box, float dt_s) const noexcept;
  bool are_one(const Box& a, const Box& b) const noexcept;
  void merge_all() noexcept;
  void remove(std::size_t index) noexcept;
  float mass_now(const Box& box) const noexcept;

  Config config_;
  SensorFrame frame_;
  EventClock clock_;
  std::vector<Box> boxes_;
  std::vector<Slot> active_;  // oldest first
  std::vector<Slot> free_;
  fast::CoarseIndex index_;
  std::uint64_t ticked_us_ = 0;
  std::int32_t next_id_ = 0;
  std::uint64_t rejected_ = 0;
};

}  // namespace asap
