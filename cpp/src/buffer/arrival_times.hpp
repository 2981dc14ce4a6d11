// ArrivalTimes: when the events of the ring arrived, by their ring index. In a live pipeline an
// event's age counts from its arrival, not from the sensor's stamp. The producer notes (index,
// time) before a push; pushes that follow within one step share the time of the first, so an event
// is at most one step younger than the table says, never older.
//
// One producer thread, one consumer thread; wait-free, no allocation after construction. note():
// O(1); of(), before(): O(log steps). Bounded: beyond half of its entries, for a consumer that has
// stalled, the steps double with every 1/32 more, so the table always spans the backlog and an age
// stays right to a few percent; when it is full, the last step goes on.
//
// Who owns what: tail_ is the producer's, head_ the consumer's. An entry is published by tail_
// before the ring publishes its events. The newest entry's time may still move while no event of it
// is in the ring, hence the relaxed atomics.
#pragma once

#include <algorithm>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>

#include "core/atomics.hpp"
#include "core/check.hpp"

namespace asap::inline v0_1 {

// Waiting events that came at one time, up to a ring index.
struct Together {
  std::int64_t time_ns;
  std::uint64_t until;
};

template <class Atomics = StdAtomics, std::size_t max_steps = 8192>
class BasicArrivalTimes {
 public:
  static constexpr std::size_t kSteps = max_steps;

  // The table has a power of two of steps, at least 32.
  explicit BasicArrivalTimes(std::int64_t step_ns, std::size_t steps = kSteps)
      : steps_(steps), step_ns_(step_ns), entries_(std::make_unique<Entry[]>(steps)) {
    require(step_ns >= 1 && step_ns <= kLongestStepNs, "step_ns", step_ns,
            "must be between 1 ns and 10^12 ns");
    require(std::has_single_bit(steps) && steps >= 32, "steps", steps,
            "must be a power of two, at least 32");
  }

  // For a ring of this capacity: a small ring pays for fewer steps, of 32 events each if it is
  // full, but 2048 at least.
  static std::size_t steps_for(std::size_t capacity) noexcept {
    return std::bit_ceil(std::clamp<std::size_t>(capacity / 32, 2048, kSteps));
  }
  static constexpr std::size_t memory_bytes(std::size_t steps) noexcept {
    return sizeof(BasicArrivalTimes) + steps * sizeof(Entry);
  }
  std::size_t steps() const noexcept { return steps_; }

  // Empty, as constructed with this width of the steps. Neither side is at work.
  void reset(std::int64_t step_ns) noexcept {
    set_step(step_ns);
    tail_.store(0, std::memory_order_relaxed);
    head_.store(0, std::memory_order_relaxed);
  }

  // Producer, before the push: events from this ring index on arrive now, and so many have been
  // thinned out before them. Times do not go back.
  void note(std::uint64_t index, std::int64_t now_ns, std::uint64_t thinned = 0) noexcept {
    const std::uint64_t tail = tail_.load(std::memory_order_relaxed);
    if (tail > 0) {
      Entry& newest = entry(tail - 1);
      if (newest.first.load(std::memory_order_relaxed) == index) {  // nothing of it was taken
        newest.time_ns.store(now_ns, std::memory_order_relaxed);
        newest.thinned.store(thinned, std::memory_order_relaxed);
        return;
      }
      const std::int64_t elapsed_ns = now_ns - newest.time_ns.load(std::memory_order_relaxed);
      const std::int64_t step_ns = step_ns_;
      if (elapsed_ns < step_ns) return;
      const auto used = static_cast<std::size_t>(tail - head_.load(std::memory_order_acquire));
      if (used == steps_ || elapsed_ns < step_ns << doublings(used)) return;
    }
    entry(tail).first.store(index, std::memory_order_relaxed);
    entry(tail).time_ns.store(now_ns, std::memory_order_relaxed);
    entry(tail).thinned.store(thinned, std::memory_order_relaxed);
    tail_.store(tail + 1, std::memory_order_release);
  }

  // Consumer. The time of an event that waits: O(1) for one of the oldest two steps.
  std::int64_t of(std::uint64_t index) const noexcept {
    return entry(step_of(index)).time_ns.load(std::memory_order_relaxed);
  }

  // Consumer. How many events had been thinned out when the step of this event began.
  std::uint64_t thinned(std::uint64_t index) const noexcept {
    return entry(step_of(index)).thinned.load(std::memory_order_relaxed);
  }

  // Any thread: another width of the steps from now on; between 1 ns and 10^12 ns.
  void set_step(std::int64_t step_ns) noexcept { step_ns_ = step_ns; }

  // Consumer. The events [index, until) came in one step, at this time; at most up to `end`.
  Together together(std::uint64_t index, std::uint64_t end) const noexcept {
    const std::uint64_t step = step_of(index);
    const std::int64_t time_ns = entry(step).time_ns.load(std::memory_order_relaxed);
    if (step + 1 == tail_.load(std::memory_order_acquire)) return {time_ns, end};
    return {time_ns, std::min(end, entry(step + 1).first.load(std::memory_order_relaxed))};
  }

  // Consumer. Of the `count` events from ring index `head` on, those before time_ns.
  std::size_t before(std::int64_t time_ns, std::uint64_t head, std::size_t count) const noexcept {
    const std::uint64_t tail = tail_.load(std::memory_order_acquire);
    const std::uint64_t step = first_step([&](const Entry& entry) {
      return entry.time_ns.load(std::memory_order_relaxed) >= time_ns;
    });
    return waiting_before(step, tail, head, count);
  }

  // Consumer. The same for newest_ns, newest_ns - step_ns, ...: as many as there are counts. Each
  // is looked for near the one before, as far back as that was.
  void before_each(std::int64_t newest_ns, std::int64_t step_ns, std::uint64_t head,
                   std::size_t count, std::span<std::size_t> counts) const noexcept {
    const std::uint64_t begin = head_.load(std::memory_order_relaxed);
    const std::uint64_t tail = tail_.load(std::memory_order_acquire);
    const auto time_before = [&](std::uint64_t step) {
      return step > begin ? entry(step - 1).time_ns.load(std::memory_order_relaxed)
                          : std::numeric_limits<std::int64_t>::min();
    };
    std::uint64_t step = tail;
    std::uint64_t stride = 1;
    std::int64_t time_ns = time_before(step);
    std::size_t waiting = count;
    for (std::size_t& older : counts) {
      if (time_ns >= newest_ns) {
        const std::uint64_t from = step;
        for (std::uint64_t jump = stride; time_ns >= newest_ns;) {
          jump = std::min(jump, step - begin);
          if (entry(step - jump).time_ns.load(std::memory_order_relaxed) >= newest_ns) {
            step -= jump;
            time_ns = time_before(step);
            jump *= 2;
          } else {
            jump /= 2;  // 1 is not too far: time_ns
          }
        }
        stride = from - step;
        waiting = waiting_before(step, tail, head, count);
      }
      older = waiting;
      newest_ns -= step_ns;
    }
  }

  // Consumer. Events before this ring index will not be asked for any more.
  void release(std::uint64_t index) noexcept {
    const std::uint64_t tail = tail_.load(std::memory_order_acquire);
    std::uint64_t head = head_.load(std::memory_order_relaxed);
    while (head + 1 < tail && entry(head + 1).first.load(std::memory_order_relaxed) <= index) {
      ++head;
    }
    head_.store(head, std::memory_order_release);
  }

 private:
  template <class Value>
  using Atomic = typename Atomics::template Atomic<Value>;
  struct Entry {
    Atomic<std::uint64_t> first{0};  // ring index of its first event
    Atomic<std::int64_t> time_ns{0};
    Atomic<std::uint64_t> thinned{0};  // before it, since the beginning
  };
  static constexpr std::int64_t kLongestStepNs = 1'000'000'000'000;

  int doublings(std::size_t used) const noexcept {
    return used > steps_ / 2 ? static_cast<int>((used - steps_ / 2) / (steps_ / 32)) : 0;
  }

  Entry& entry(std::uint64_t i) noexcept { return entries_[i & (steps_ - 1)]; }
  const Entry& entry(std::uint64_t i) const noexcept { return entries_[i & (steps_ - 1)]; }

  // Returns how many waiting events lie before this step: all of them if it is the tail.
  std::size_t waiting_before(std::uint64_t step, std::uint64_t tail, std::uint64_t head,
                             std::size_t count) const noexcept {
    if (step == tail) return count;
    const std::uint64_t index = entry(step).first.load(std::memory_order_relaxed);
    return index <= head ? 0 : std::min(count, static_cast<std::size_t>(index - head));
  }

  // The step that holds an event of this index: mostly one of the oldest two.
  std::uint64_t step_of(std::uint64_t index) const noexcept {
    const auto is_beyond = [&](const Entry& entry) {
      return entry.first.load(std::memory_order_relaxed) > index;
    };
    const std::uint64_t tail = tail_.load(std::memory_order_acquire);
    const std::uint64_t oldest = head_.load(std::memory_order_relaxed);
    for (std::uint64_t step = oldest; step < oldest + 2; ++step) {
      if (step + 1 == tail || is_beyond(entry(step + 1))) return step;
    }
    return first_step(is_beyond) - 1;
  }

  // The first step that `is_beyond`; those behind it are, too.
  template <class IsBeyond>
  std::uint64_t first_step(const IsBeyond& is_beyond) const noexcept {
    std::uint64_t begin = head_.load(std::memory_order_relaxed);
    std::uint64_t end = tail_.load(std::memory_order_acquire);
    while (begin < end) {
      const std::uint64_t middle = begin + (end - begin) / 2;
      if (is_beyond(entry(middle))) {
        end = middle;
      } else {
        begin = middle + 1;
      }
    }
    return begin;
  }

  static constexpr std::size_t kApart = 128;  // as in the ring
  const std::size_t steps_;
  Relaxed<std::int64_t> step_ns_;
  const std::unique_ptr<Entry[]> entries_;
  alignas(kApart) Atomic<std::uint64_t> tail_{0};
  alignas(kApart) Atomic<std::uint64_t> head_{0};
};

using ArrivalTimes = BasicArrivalTimes<>;

}  // namespace asap::inline v0_1
