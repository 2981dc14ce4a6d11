// ConsumerLoop: the consumer's side of a run in real time. Waits for the next package, and takes
// the time that the algorithm needs for it: from the moment the package is taken to complete().
//
//   while (loop.next(package, patience) != Next::ended) loop.work(package, algorithm);
//
// One thread, but for flush() and abandon(). Never polls: it sleeps at the doorbell.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>

#include "asap/buffer/event_buffer.hpp"
#include "asap/packager/packager.hpp"
#include "asap/runner/clock.hpp"
#include "asap/runner/consumer.hpp"
#include "asap/runner/doorbell.hpp"

namespace asap {

class ConsumerLoop {
 public:
  enum class Next { package, idle, ended };

  // The referenced objects outlive the loop.
  ConsumerLoop(EventBuffer& buffer, Packager& packager, Telemetry& telemetry, Doorbell& doorbell,
               const RunClock& clock) noexcept
      : buffer_(buffer),
        packager_(packager),
        telemetry_(telemetry),
        doorbell_(doorbell),
        clock_(clock) {}

  // Waits for a package, at most for `patience` (then idle). ended: the source has ended and all is
  // delivered.
  Next next(Package& package, std::chrono::nanoseconds patience);

  // Any thread. What is in the ring now is due.
  void flush() noexcept;

  // Any thread. next() says ended, whatever still waits.
  void abandon() noexcept;

  // Hands the package to the algorithm, whole or part by part, and completes it.
  void work(Package package, const Consumer& algorithm);

  // For a caller who has processed package.events himself.
  void complete(const Package& package) noexcept { packager_.complete(package, clock_.now_ns()); }

 private:
  // What other threads have asked for.
  struct Asked {
    bool closed;
    bool abandoned;
    std::uint64_t flush;

    friend bool operator==(const Asked&, const Asked&) = default;
  };
  Asked asked() const noexcept;

  EventBuffer& buffer_;
  Packager& packager_;
  Telemetry& telemetry_;
  Doorbell& doorbell_;
  const RunClock& clock_;
  std::atomic<bool> abandoned_{false};
  std::atomic<std::uint64_t> flush_{0};  // ring index
};

}  // namespace asap
