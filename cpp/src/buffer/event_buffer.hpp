// EventBuffer: the bounded ring between the thread that receives events and the thread that works
// on them. One producer thread (push, close), one consumer thread (peek, consume); the counters may
// be read from anywhere.
//
// push is wait-free: bounded steps, no lock, no allocation, no system call. A full ring drops the
// newest events, those that do not fit, and counts them. Memory is allocated once, in the
// constructor.
//
// A push that finds the ring empty, and itself `near` slots or more behind the first, begins at the
// first slot again. A consumer that keeps up is so served from memory that is in the cache, and
// a page that no backlog has needed is never touched.
//
// Memory order. Each index has one writer. The producer writes events, then stores tail_ with
// release; the consumer loads tail_ with acquire, so it sees them. The consumer is done with the
// events, then stores head_ with release; the producer loads head_ with acquire before it
// overwrites their slots. closed_ is stored with release after the last tail_: a consumer that
// reads closed() == true and then peeks once more sees everything that was pushed. base_, the index
// at the first slot, is stored before tail_ and loaded after it; it changes only while nothing
// waits, so it belongs to the tail that was loaded. Each side keeps a copy of the other's index and
// refreshes it only when the copy says full (or empty): most calls touch no shared line.
#pragma once

#include <algorithm>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>

#include "asap/core/event.hpp"
#include "asap/core/nonblocking.hpp"
#include "core/atomics.hpp"
#include "core/check.hpp"

namespace asap::inline v0_1 {

// Events in arrival order, in at most two contiguous pieces (the ring wraps once).
struct EventPieces {
  EventSpan first;
  EventSpan second;

  std::size_t size() const noexcept { return first.size() + second.size(); }
  const Event& operator[](std::size_t i) const noexcept {
    return i < first.size() ? first[i] : second[i - first.size()];
  }
  // count <= size()
  EventPieces oldest(std::size_t count) const noexcept {
    const std::size_t from_first = std::min(count, first.size());
    return {first.first(from_first), second.first(count - from_first)};
  }
};

template <class Atomics = StdAtomics, std::size_t near = std::size_t{1} << 14>
class BasicEventBuffer {
 public:
  static constexpr std::size_t kMaxCapacity = std::size_t{1} << 40;

  // Throws std::invalid_argument for a capacity out of range, NoMemory for one that cannot be had.
  // `first_index` starts the 64-bit indices elsewhere than at 0, for tests of their wrap.
  explicit BasicEventBuffer(std::size_t capacity, std::uint64_t first_index = 0)
      : capacity_(checked(capacity)),
        mask_(std::bit_ceil(capacity) - 1),
        slots_(detail::allocate<Event>(std::bit_ceil(capacity), "capacity", capacity)),
        tail_(first_index),
        head_copy_(first_index),
        head_(first_index),
        tail_copy_(first_index) {}

  static std::size_t memory_bytes(std::size_t capacity) noexcept {
    return std::bit_ceil(capacity) * sizeof(Event);
  }

  // Writes to all slots, so that no page of them is missing later. Before the first push.
  void prefault() noexcept { std::fill_n(slots_.get(), mask_ + 1, Event{}); }

  // Empty and open, as constructed. Neither side is at work.
  void reset() noexcept {
    for (auto* count : {&tail_, &base_, &overflow_, &head_}) {
      count->store(0, std::memory_order_relaxed);
    }
    closed_.store(false, std::memory_order_relaxed);
    head_copy_ = tail_copy_ = base_copy_ = 0;
  }

  // Producer. Takes the oldest events of the span that fit, counts the rest as overflow.
  // Returns how many were taken.
  std::size_t push(EventSpan events) noexcept ASAP_NONBLOCKING {
    const std::uint64_t tail = tail_.load(std::memory_order_relaxed);
    if (capacity_ - (tail - head_copy_) < events.size()) {
      head_copy_ = head_.load(std::memory_order_acquire);
    }
    const std::size_t free = capacity_ - static_cast<std::size_t>(tail - head_copy_);
    const std::size_t taken = std::min(events.size(), free);
    if (taken < events.size()) {
      const std::uint64_t lost = overflow_.load(std::memory_order_relaxed);
      overflow_.store(lost + (events.size() - taken), std::memory_order_relaxed);
    }
    const std::size_t begin = place_of(tail);
    const std::size_t until_wrap = std::min(taken, mask_ + 1 - begin);
    std::copy_n(events.data(), until_wrap, slots_.get() + begin);
    std::copy_n(events.data() + until_wrap, taken - until_wrap, slots_.get());
    tail_.store(tail + taken, std::memory_order_release);
    return taken;
  }

  // Producer. Events that wait, at least when they are more than `enough`: looks at the consumer's
  // index only then.
  std::size_t filled(std::size_t enough) noexcept {
    const std::uint64_t tail = tail_.load(std::memory_order_relaxed);
    if (tail - head_copy_ > enough) head_copy_ = head_.load(std::memory_order_acquire);
    return static_cast<std::size_t>(tail - head_copy_);
  }

  // Producer. No push follows.
  void close() noexcept { closed_.store(true, std::memory_order_release); }

  // Consumer. The oldest waiting events, at most `limit`; they stay valid until consumed.
  EventPieces peek(std::size_t limit = std::numeric_limits<std::size_t>::max()) noexcept
      ASAP_NONBLOCKING {
    const std::uint64_t head = head_.load(std::memory_order_relaxed);
    if (tail_copy_ - head < limit) {
      tail_copy_ = tail_.load(std::memory_order_acquire);
      base_copy_ = base_.load(std::memory_order_relaxed);
    }
    const std::size_t size = std::min(limit, static_cast<std::size_t>(tail_copy_ - head));
    const std::size_t begin = slot(head, base_copy_);
    const std::size_t until_wrap = std::min(size, mask_ + 1 - begin);
    return {{slots_.get() + begin, until_wrap}, {slots_.get(), size - until_wrap}};
  }

  // Consumer. Frees the `count` oldest events; count <= what the last peek returned.
  void consume(std::size_t count) noexcept ASAP_NONBLOCKING {
    head_.store(head_.load(std::memory_order_relaxed) + count, std::memory_order_release);
  }

  bool closed() const noexcept { return closed_.load(std::memory_order_acquire); }
  std::size_t capacity() const noexcept { return capacity_; }

  // Events that wait: never too few for the producer, never too many for the consumer, a snapshot
  // for others.
  std::size_t size() const noexcept {
    const std::uint64_t head = head_.load(std::memory_order_acquire);
    const std::uint64_t waiting = tail_.load(std::memory_order_acquire) - head;
    return std::min(static_cast<std::size_t>(waiting), capacity_);
  }

  // Indices after the newest event pushed and after the newest event consumed.
  std::uint64_t tail() const noexcept { return tail_.load(std::memory_order_acquire); }
  std::uint64_t head() const noexcept { return head_.load(std::memory_order_acquire); }
  // Events that did not fit.
  std::uint64_t overflow() const noexcept { return overflow_.load(std::memory_order_relaxed); }

 private:
  static std::size_t checked(std::size_t capacity) {
    require(capacity >= 1 && capacity <= kMaxCapacity, "capacity", capacity,
            "must be between 1 and 2^40 events");
    return capacity;
  }

  std::size_t slot(std::uint64_t index, std::uint64_t base) const noexcept {
    return static_cast<std::size_t>(index - base) & mask_;
  }

  // Producer. The slot of the next event.
  std::size_t place_of(std::uint64_t tail) noexcept {
    const std::uint64_t base = base_.load(std::memory_order_relaxed);
    const std::size_t place = slot(tail, base);
    if (place < near) return place;
    if (tail != head_copy_) head_copy_ = head_.load(std::memory_order_acquire);
    if (tail != head_copy_) return place;
    base_.store(tail, std::memory_order_relaxed);
    return 0;
  }

  // 128 bytes apart: a pair of cache lines is fetched together on x86, a line is 128 bytes on some
  // ARM.
  static constexpr std::size_t kApart = 128;
  template <class Value>
  using Atomic = typename Atomics::template Atomic<Value>;

  const std::size_t capacity_;
  const std::size_t mask_;
  const std::unique_ptr<Event[]> slots_;

  alignas(kApart) Atomic<std::uint64_t> tail_;  // written by the producer
  std::uint64_t head_copy_;                     // the producer's own
  Atomic<std::uint64_t> base_{0};               // written by the producer
  Atomic<std::uint64_t> overflow_{0};           // written by the producer
  Atomic<bool> closed_{false};                  // written by the producer

  alignas(kApart) Atomic<std::uint64_t> head_;  // written by the consumer
  std::uint64_t tail_copy_;                     // the consumer's own
  std::uint64_t base_copy_ = 0;                 // the consumer's own
};

using EventBuffer = BasicEventBuffer<>;

}  // namespace asap::inline v0_1
