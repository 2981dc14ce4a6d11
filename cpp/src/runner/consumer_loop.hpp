// ConsumerLoop: the consumer's side of a run in real time. Waits for the next package, and takes
// the time that the algorithm needs for it: from the moment the package is taken to complete().
//
//   while (loop.next(package, patience) != Next::ended) loop.work(package, algorithm);
//
// One thread, but for flush(), abandon(), set_latency_bound() and stalled(). Never polls: it sleeps
// at the doorbell.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>

#include "asap/runner/run_config.hpp"
#include "buffer/event_buffer.hpp"
#include "packager/packager.hpp"
#include "runner/clock.hpp"
#include "runner/doorbell.hpp"
#include "runner/stall_watch.hpp"

namespace asap::inline v0_1 {

class ConsumerLoop {
 public:
  using Next = asap::Next;
  using Poll = std::function<void()>;

  // The referenced objects outlive the loop. `room`: where a producer sleeps that waits for free
  // slots; may be none.
  ConsumerLoop(EventBuffer& buffer, Packager& packager, Telemetry& telemetry, Doorbell& doorbell,
               const RunClock& clock, Doorbell* room = nullptr) noexcept
      : buffer_(buffer),
        packager_(packager),
        telemetry_(telemetry),
        doorbell_(doorbell),
        clock_(clock),
        room_(room) {}

  // Waits for a package, at most for `patience` (then idle); calls `poll` every 20 ms of it, which
  // may throw. ended: the source has ended and all is delivered.
  Next next(Package& package, std::chrono::nanoseconds patience, const Poll& poll = {});

  // Any thread. What is in the ring now is due.
  void flush() noexcept;

  // Any thread. Another latency bound, from the next look on.
  void set_latency_bound(std::int64_t bound_ns) noexcept;

  // Any thread. The consumer has been away for too long, though `waiting` events wait for it.
  bool stalled(std::size_t waiting) const noexcept;

  // Producer, before the first push.
  void begin() noexcept;

  // Any thread. next() says ended, whatever still waits.
  void abandon() noexcept;

  // Hands the package to the algorithm, whole or part by part, and completes it.
  void work(Package package, const Consumer& algorithm);

  // Works until next() says ended. `poll` is called every 20 ms or, while the algorithm works,
  // between two packages; it may throw. What either throws comes out unchanged.
  void run(const Consumer& algorithm, const Poll& poll = {});

  // For a caller who has processed package.events himself.
  void complete(const Package& package) noexcept { packager_.complete(package, clock_.now_ns()); }

 private:
  // What other threads have asked for.
  struct Asked {
    bool closed;
    bool abandoned;
    std::uint64_t flush;
    std::int64_t bound_ns;  // 0: as it was

    friend bool operator==(const Asked&, const Asked&) = default;
  };
  Next wait(Package& package, std::chrono::nanoseconds patience);
  Asked asked() const noexcept;
  void heed(const Asked& asked) noexcept;

  EventBuffer& buffer_;
  Packager& packager_;
  Telemetry& telemetry_;
  Doorbell& doorbell_;
  const RunClock& clock_;
  Doorbell* const room_;
  StallWatch watch_;
  std::atomic<bool> abandoned_{false};
  std::atomic<std::uint64_t> flush_{0};    // ring index
  std::atomic<std::int64_t> bound_ns_{0};  // 0: as it was
};

}  // namespace asap::inline v0_1
