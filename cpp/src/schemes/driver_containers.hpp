// DriverContainers: cuts a stream where a camera driver would have delivered it, after 1000 events
// or 20 ms, whichever comes first; empty times deliver nothing. Asap2022 counts its rate in such
// containers. It is told of many events at once and spreads them evenly over their time. O(1) per
// container, no allocation.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace asap::inline v0_1 {

class DriverContainers {
 public:
  static constexpr std::size_t kEvents = 1000;
  static constexpr std::int64_t kLongestNs = 20'000'000;

  // `count` more events, spread over [from_ns, until_ns); deliver(time_ns) for each container that
  // they complete. Time does not go back.
  template <class Deliver>
  void pass(std::size_t count, std::int64_t from_ns, std::int64_t until_ns, Deliver&& deliver) {
    if (!is_begun_) begin_ns_ = from_ns;
    is_begun_ = true;
    const double step_ns =
        (static_cast<double>(until_ns) - static_cast<double>(from_ns)) / static_cast<double>(count);
    const auto time_ns = [&](std::size_t i) {
      return from_ns + static_cast<std::int64_t>(static_cast<double>(i) * step_ns);
    };
    for (std::size_t i = 0; i < count;) {
      const std::int64_t timeout_ns = begin_ns_ + kLongestNs;
      const std::size_t in_time = std::max(i, before(timeout_ns, from_ns, step_ns, count));
      if (in_time - i >= left()) {
        i += left();
        held_ = 0;
        begin_ns_ = time_ns(i - 1);
        deliver(begin_ns_);
      } else if (in_time == count) {
        held_ += count - i;
        i = count;
      } else if (held_ + (in_time - i) > 0) {
        i = in_time;
        held_ = 0;
        deliver(timeout_ns);
      } else {
        begin_ns_ += (time_ns(i) - begin_ns_) / kLongestNs * kLongestNs;
        held_ = 1;
        ++i;
      }
    }
  }

  // Events until the open container is full, at least 1.
  std::size_t left() const noexcept { return kEvents - held_; }

 private:
  // How many of the events lie before this time.
  static std::size_t before(std::int64_t time_ns, std::int64_t from_ns, double step_ns,
                            std::size_t count) noexcept {
    const double ahead_ns = static_cast<double>(time_ns) - static_cast<double>(from_ns);
    if (ahead_ns <= 0) return 0;
    const double events = std::ceil(ahead_ns / step_ns);  // infinite for equal times
    return events < static_cast<double>(count) ? static_cast<std::size_t>(events) : count;
  }

  std::size_t held_ = 0;  // events of the open container, < kEvents
  std::int64_t begin_ns_ = 0;
  bool is_begun_ = false;
};

}  // namespace asap::inline v0_1
