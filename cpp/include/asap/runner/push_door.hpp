// PushDoor: lets one producer at a time into a pipeline, and shuts it. When close() has returned no
// producer is inside and none will get in, so what the producer owned may be read. Entering and
// leaving are one atomic operation each: wait-free. close() waits for at most one push.
#pragma once

#include <atomic>
#include <cstdint>
#include <thread>

#include "asap/core/atomics.hpp"

namespace asap {

// How close() waits for the producer inside.
struct YieldingWait {
  static void pause() noexcept { std::this_thread::yield(); }
};

template <class Atomics = StdAtomics, class Wait = YieldingWait>
class BasicPushDoor {
 public:
  // The producer's visit: inside while the object lives, if it is let in.
  class Visit {
   public:
    explicit Visit(BasicPushDoor& door) noexcept : door_(door), inside_(door.enter()) {}
    ~Visit() {
      if (inside_) door_.leave();
    }
    Visit(const Visit&) = delete;
    Visit& operator=(const Visit&) = delete;

    // False: the door is shut, or somebody else is inside.
    bool inside() const noexcept { return inside_; }

   private:
    BasicPushDoor& door_;
    const bool inside_;
  };

  // Any thread.
  void open() noexcept { state_.fetch_or(kOpen, std::memory_order_acq_rel); }
  void close() noexcept {
    state_.fetch_and(~kOpen, std::memory_order_acq_rel);
    while ((state_.load(std::memory_order_acquire) & kInside) != 0) Wait::pause();
  }
  bool is_open() const noexcept { return (state_.load(std::memory_order_acquire) & kOpen) != 0; }

 private:
  static constexpr std::uint32_t kOpen = 1;
  static constexpr std::uint32_t kInside = 2;

  bool enter() noexcept {
    const std::uint32_t before = state_.fetch_or(kInside, std::memory_order_acq_rel);
    if (before == kOpen) return true;
    if ((before & kInside) == 0) leave();  // it was ours, at a shut door
    return false;
  }
  void leave() noexcept { state_.fetch_and(~kInside, std::memory_order_acq_rel); }

  alignas(128) typename Atomics::template Atomic<std::uint32_t> state_{0};
};

using PushDoor = BasicPushDoor<>;

}  // namespace asap
