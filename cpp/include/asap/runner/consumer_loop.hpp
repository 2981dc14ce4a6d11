// ConsumerLoop: the consumer's side of a run in real time. Waits for the next package, and takes
// the time that the algorithm needs for it: from the moment the package is taken to complete().
//
//   while (loop.next(package, patience) != Next::ended) loop.work(package, algorithm);
//
// One thread. Never polls: it sleeps at the doorbell.
#pragma once

#include <chrono>

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

  // Hands the package to the algorithm, whole or part by part, and completes it.
  void work(Package package, const Consumer& algorithm);

  // For a caller who has processed package.events himself.
  void complete(const Package& package) noexcept { packager_.complete(package, clock_.now_ns()); }

 private:
  EventBuffer& buffer_;
  Packager& packager_;
  Telemetry& telemetry_;
  Doorbell& doorbell_;
  const RunClock& clock_;
};

}  // namespace asap
