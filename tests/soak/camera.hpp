// Camera: makes the events of a push, in memory of its own: random pixels, stamps that go on. And
// pushes them in real time, so many a second, in packets of a millisecond, from the thread that
// calls.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "asap/runner/pipeline.hpp"

namespace asap::soak {

class Camera {
 public:
  static constexpr int kWidth = 346;
  static constexpr int kHeight = 260;

  explicit Camera(std::size_t largest_packet, std::uint64_t seed = 1);

  // So many events, evenly over the next `span_us`.
  std::span<Event> packet(std::size_t count, std::int64_t span_us) noexcept;

  // What it took to push for so many seconds.
  struct Pushed {
    std::uint64_t events = 0;
    double cpu_s = 0;      // inside push()
    double longest_s = 0;  // one push()
    double late_s = 0;     // the packet that came latest: how busy the machine is
  };
  Pushed push_paced(Pipeline& pipeline, double events_per_s, double seconds);

 private:
  std::vector<Event> events_;
  std::int64_t now_us_ = 0;
};

}  // namespace asap::soak
