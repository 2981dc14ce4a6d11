// Intake: the producer's way into the ring of a live run, by one of the rules of WhenFull.
// Wait-free and without a system call but for the one that wakes a consumer who sleeps; with
// WhenFull::block it waits for room instead. No allocation.
//
// The thinning has no state but the ring itself: of events that find it filled to a share f of its
// capacity beyond 3/4 the fraction 4 (1 - f) gets in, so a ring that somebody empties never fills,
// whatever comes, and opens by itself. A push that finds it emptier than that gets in whole; what
// finds it full is overflow: nobody empties it. (The rule of halving a threshold again and again,
// made continuous.)
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>

#include "asap/buffer/arrival_times.hpp"
#include "asap/buffer/event_buffer.hpp"
#include "asap/core/relaxed.hpp"
#include "asap/filter/gamma_filter.hpp"
#include "asap/runner/doorbell.hpp"
#include "asap/runner/when_full.hpp"

namespace asap {

class Intake {
 public:
  using Poll = std::function<void()>;

  // The referenced objects outlive this one.
  Intake(EventBuffer& buffer, ArrivalTimes& arrivals, Doorbell& doorbell, WhenFull when_full,
         std::uint64_t seed) noexcept
      : buffer_(buffer),
        arrivals_(arrivals),
        doorbell_(doorbell),
        when_full_(when_full),
        filter_(seed) {}

  // Producer. `poll` is called every 20 ms while it waits for room; it may throw: then what has not
  // got in counts as overflow, as it does after leave().
  void take(EventSpan events, std::int64_t arrival_ns, const Poll& poll = {});

  // Where the producer sleeps that waits for room; none if it never does.
  Doorbell* room() noexcept { return when_full_ == WhenFull::block ? &room_ : nullptr; }

  // Any thread: a producer that waits for room gives up, now and in future.
  void leave() noexcept;

  // Events that the thinning has discarded.
  std::uint64_t discarded() const noexcept { return discarded_; }

 private:
  static constexpr std::size_t kBlock = 256;

  std::size_t put(EventSpan events, std::int64_t arrival_ns) noexcept;
  void thin(EventSpan events, std::int64_t arrival_ns) noexcept;
  void wait_for_room(std::size_t wanted, const Poll& poll);

  EventBuffer& buffer_;
  ArrivalTimes& arrivals_;
  Doorbell& doorbell_;
  const WhenFull when_full_;
  GammaFilter filter_;
  Relaxed<std::uint64_t> discarded_;
  Doorbell room_;  // the producer sleeps there
  std::atomic<bool> left_{false};
  std::array<Event, kBlock> scratch_;
};

}  // namespace asap
