// EventTimes: when an event came, as the packager and the schemes see it. Of a recording that is
// its timestamp on the run's axis; in a live pipeline its arrival, because the sensor's clock is
// not ours and a transport delay must make no event stale. One branch that is always the same; the
// consumer's thread.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "asap/core/time.hpp"
#include "buffer/age_slots.hpp"
#include "buffer/arrival_times.hpp"
#include "buffer/event_buffer.hpp"

namespace asap::inline v0_1 {

class EventTimes {
 public:
  // By timestamp, every count exact.
  EventTimes() = default;
  // The referenced object outlives this one. By timestamp:
  EventTimes(const AgeSlots& ages) noexcept : ages_(&ages) {}
  // By arrival:
  EventTimes(ArrivalTimes& arrivals) noexcept : arrivals_(&arrivals) {}

  bool by_arrival() const noexcept { return arrivals_ != nullptr; }
  // How many the table of arrival times has; 0 where times are stamps.
  std::size_t steps() const noexcept { return by_arrival() ? arrivals_->steps() : 0; }

  // Where timestamps lie in run time.
  void set_axis(TimeAxis axis) noexcept { axis_ = axis; }
  const TimeAxis& axis() const noexcept { return axis_; }

  // Run time of a waiting event, which lies at this ring index.
  std::int64_t of(const Event& event, std::uint64_t index) const noexcept {
    return by_arrival() ? arrivals_->of(index) : axis_.to_ns(event.t);
  }

  // Those of the waiting events [index, end) that can be treated together; by timestamp all, of no
  // one time.
  Together together(std::uint64_t index, std::uint64_t end) const noexcept {
    return by_arrival() ? arrivals_->together(index, end) : Together{0, end};
  }

  // Counts the waiting events before time_ns; the oldest lies at ring index `head`.
  std::size_t before(std::int64_t time_ns, const EventPieces& waiting,
                     std::uint64_t head) const noexcept {
    if (by_arrival()) return arrivals_->before(time_ns, head, waiting.size());
    const auto count = [&](EventSpan events) {
      const auto end = std::partition_point(events.begin(), events.end(), [&](const Event& event) {
        return axis_.to_ns(event.t) < time_ns;
      });
      return static_cast<std::size_t>(end - events.begin());
    };
    return count(waiting.first) + count(waiting.second);
  }

  // The same, right to the share of one age slot.
  std::size_t about_before(std::int64_t time_ns, std::int64_t now_ns, const EventPieces& waiting,
                           std::uint64_t head) const noexcept {
    if (by_arrival()) return arrivals_->before(time_ns, head, waiting.size());
    if (ages_ == nullptr) return before(time_ns, waiting, head);
    return ages_->before(time_ns, now_ns, head, waiting.size());
  }

  // The same for newest_ns, newest_ns - step_ns, ...: as many as there are counts.
  void about_before_each(std::int64_t newest_ns, std::int64_t step_ns, std::int64_t now_ns,
                         const EventPieces& waiting, std::uint64_t head,
                         std::span<std::size_t> counts) const noexcept {
    if (by_arrival()) {
      arrivals_->before_each(newest_ns, step_ns, head, waiting.size(), counts);
    } else if (ages_ != nullptr) {
      ages_->before_each(newest_ns, step_ns, now_ns, head, waiting.size(), counts);
    } else {
      for (std::size_t& older : counts) {
        older = before(newest_ns, waiting, head);
        newest_ns -= step_ns;
      }
    }
  }

  // Events thinned out before this one, a waiting one, since the beginning: right to a step.
  std::uint64_t thinned(std::uint64_t index) const noexcept {
    return by_arrival() ? arrivals_->thinned(index) : 0;
  }

  // Events before this ring index have left the ring.
  void release(std::uint64_t head) noexcept {
    if (by_arrival()) arrivals_->release(head);
  }

 private:
  const AgeSlots* ages_ = nullptr;
  ArrivalTimes* arrivals_ = nullptr;
  TimeAxis axis_;
};

// When the kept events of the package in work arrived, in runs of one time. The filter loses the
// ring index of an event, so the packager notes it before. No allocation after construction.
class KeptTimes {
 public:
  struct Run {
    std::size_t end;  // of the kept events; the run begins where the one before ends
    std::int64_t time_ns;
  };

  explicit KeptTimes(std::size_t runs) : runs_(runs) {}
  static constexpr std::size_t memory_bytes(std::size_t runs) noexcept {
    return runs * sizeof(Run);
  }

  void clear() noexcept { size_ = 0; }

  // The kept events up to `end`, beyond those noted before, came at this time. At most as many runs
  // as said at construction.
  void note(std::size_t end, std::int64_t time_ns) noexcept {
    if (end > (size_ == 0 ? 0 : runs_[size_ - 1].end)) runs_[size_++] = {end, time_ns};
  }

  std::span<const Run> runs() const noexcept { return {runs_.data(), size_}; }

 private:
  std::vector<Run> runs_;
  std::size_t size_ = 0;
};

}  // namespace asap::inline v0_1
