// FeedbackGate: where the worker waits for the consumer of its packages to say that it has finished
// the one in flight. There is at most one.
//
// sent() and wait() are the worker's; any thread gives feedback, opens and closes. O(1).
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>

namespace asap::ros {

class FeedbackGate {
 public:
  using Clock = std::chrono::steady_clock;

  struct Counts {
    std::uint64_t taken = 0;
    std::uint64_t refused = 0;   // no time, or of no package in flight
    std::uint64_t timeouts = 0;  // packages without feedback
    bool stalled = false;        // the last package had none
  };

  // A package is about to leave.
  void sent();

  // Until the feedback for it has come, the patience has ended or the gate is closed.
  void wait(Clock::duration patience);

  // Until then, or until the gate is closed.
  void pause(Clock::time_point until);

  // The consumer has worked for so long. False for what is no time, and where it is longer than the
  // package in flight has been out: it belongs to an earlier one, whose time was up.
  bool feedback(double seconds);

  // Waits last no longer, until open().
  void close();
  void open();

  Counts counts() const;

 private:
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  Clock::time_point sent_{};
  bool in_flight_ = false;
  bool closed_ = false;
  Counts counts_;
};

}  // namespace asap::ros
