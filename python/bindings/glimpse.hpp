// Glimpse: some of the events that an algorithm gets, for a picture. Any thread asks; the consumer
// fills, and neither waits for the thread that asks nor allocates.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <mutex>
#include <utility>
#include <vector>

#include "asap/core/event.hpp"

namespace asap::python {

class Glimpse {
 public:
  static constexpr std::size_t kMost = std::size_t{1} << 16;  // events

  // Returns what was collected, and collects anew from now on if `more` is asked for.
  std::vector<Event> take(bool more) {
    std::vector<Event> events(more ? kMost : 0);  // written to: the consumer shall miss no page
    events.clear();
    {
      const std::lock_guard turn(mutex_);
      events_.swap(events);
    }
    wanted_.store(more, std::memory_order_relaxed);
    return events;
  }

  // The consumer's.
  void note(EventSpan events) noexcept {
    if (!wanted_.load(std::memory_order_relaxed)) return;
    const std::unique_lock turn(mutex_, std::try_to_lock);
    if (!turn) return;
    const auto newest = events.last(std::min(events.size(), events_.capacity() - events_.size()));
    events_.insert(events_.end(), newest.begin(), newest.end());
  }

 private:
  std::atomic<bool> wanted_{false};
  std::mutex mutex_;
  std::vector<Event> events_;
};

}  // namespace asap::python
