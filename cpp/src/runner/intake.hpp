// Intake: the producer's way into the ring of a live run, by one of the rules of WhenFull.
// Wait-free and without a system call but for the one that wakes a consumer who sleeps; with
// WhenFull::block it waits for room instead. No allocation.
//
// The thinning has no state but the ring itself. A push that leaves a quarter q of the ring free
// gets in whole. Beyond, where r slots are free, an event gets in with probability (r / q)^2, so
// that m events take the room from r to r / (1 + r m / q^2). All events of a push have the same
// chance, such that it ends where that law does: what gets in is uniform in time, and no size of
// push overflows. A ring that the consumer empties never fills, whatever comes, and opens by
// itself; without a consumer it is full after some q^2 events, and the rest is overflow.
// (Halving a threshold again and again, made continuous; by the square, because its integral is
// the same bits everywhere.)
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>

#include "asap/filter/gamma_filter.hpp"
#include "asap/runner/run_config.hpp"
#include "buffer/arrival_times.hpp"
#include "buffer/event_buffer.hpp"
#include "core/atomics.hpp"
#include "runner/doorbell.hpp"
#include "telemetry/gap_meter.hpp"

namespace asap::inline v0_1 {

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

  // Producer. By the rule.
  void take(EventSpan events, std::int64_t arrival_ns) noexcept;

  // The same. `poll` is called every 20 ms while it waits for room; it may throw: then what has not
  // got in counts as overflow, as it does after leave().
  void take(EventSpan events, std::int64_t arrival_ns, const Poll& poll);

  // Producer. What there is room for, whatever the rule; the rest is overflow.
  void put(EventSpan events, std::int64_t arrival_ns) noexcept;

  // Producer, at the end of a push: wakes the consumer if it waits for what has come. A push may
  // come in pieces, which are to make one package.
  void announce() noexcept { doorbell_.announce(buffer_.tail()); }

  // Where the producer sleeps that waits for room; none if it never does.
  Doorbell* room() noexcept { return when_full_ == WhenFull::block ? &room_ : nullptr; }

  // Any thread: a producer that waits for room gives up, now and in future.
  void leave() noexcept;

  // Events that the thinning has discarded.
  std::uint64_t discarded() const noexcept { return discarded_; }

  // The gaps that discarded and overflowed events leave.
  const GapMeter& gap() const noexcept { return gap_; }

  // The most events that have waited at once, also while the producer waits for room.
  std::uint64_t max_waiting() const noexcept { return max_waiting_; }

 private:
  static constexpr std::size_t kBlock = 256;

  void put_waiting(EventSpan events, std::int64_t arrival_ns, const Poll& poll);
  void thin(EventSpan events, std::int64_t arrival_ns) noexcept;
  std::size_t enter(EventSpan events, std::int64_t arrival_ns) noexcept;
  KeepThreshold bar(double share, std::size_t events, std::size_t room) noexcept;
  void wait_for_room(std::size_t wanted, const Poll& poll);

  EventBuffer& buffer_;
  ArrivalTimes& arrivals_;
  Doorbell& doorbell_;
  const WhenFull when_full_;
  GammaFilter filter_;
  Relaxed<std::uint64_t> discarded_;
  Relaxed<std::uint64_t> max_waiting_;
  GapMeter gap_;
  Doorbell room_;  // the producer sleeps there
  std::atomic<bool> left_{false};
  std::array<Event, kBlock> scratch_{};  // written at construction: no page is missing later
  std::array<std::uint64_t, kBlock> numbers_{};
};

}  // namespace asap::inline v0_1
