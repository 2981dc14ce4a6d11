// PushDoor: lets one producer at a time into a pipeline, and shuts it. The thread that shuts it
// does not wait for the producer inside, which may wait for that thread: the last one out does what
// is to be done at the end, so what the producer owned may be read then. Entering and leaving are
// wait-free.
#pragma once

#include <atomic>
#include <cstdint>
#include <thread>
#include <utility>

#include "core/atomics.hpp"

namespace asap::inline v0_1 {

// How wait_until_empty() waits for the producer inside.
struct YieldingWait {
  static void pause() noexcept { std::this_thread::yield(); }
};

template <class Atomics = StdAtomics, class Wait = YieldingWait>
class BasicPushDoor {
 public:
  // Any thread. False: the door is shut, or a producer is inside.
  bool enter() noexcept {
    std::uint32_t empty = kOpen;
    return state_.compare_exchange_strong(empty, kOpen | kInside, std::memory_order_acq_rel);
  }
  // Called by the producer inside. Runs last_out first if the door was shut meanwhile.
  template <class LastOut>
  void leave(LastOut&& last_out) noexcept {
    std::uint32_t open = kOpen | kInside;
    if (state_.compare_exchange_strong(open, kOpen, std::memory_order_acq_rel)) return;
    std::forward<LastOut>(last_out)();
    state_.store(0, std::memory_order_release);
  }

  // Any thread. True: it was open, and no producer is inside.
  bool shut() noexcept { return state_.fetch_and(~kOpen, std::memory_order_acq_rel) == kOpen; }
  // Waits until the last push is out. Precondition: the door is shut.
  void wait_until_empty() const noexcept {
    while (state_.load(std::memory_order_acquire) != 0) Wait::pause();
  }
  // Precondition: the door is shut and empty.
  void open() noexcept { state_.store(kOpen, std::memory_order_release); }
  bool is_open() const noexcept { return (state_.load(std::memory_order_acquire) & kOpen) != 0; }

 private:
  static constexpr std::uint32_t kOpen = 1;
  static constexpr std::uint32_t kInside = 2;

  alignas(128) typename Atomics::template Atomic<std::uint32_t> state_{0};
};

using PushDoor = BasicPushDoor<>;

}  // namespace asap::inline v0_1
