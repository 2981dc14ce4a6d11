// FeedbackGate: where the worker waits for the consumer of its packages to say that it has finished
// the message in flight. There is at most one.
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

  // The message with this number, 1 or more, is about to leave; a package has one or several.
  void sent(std::uint64_t seq);

  // Until the feedback for it has come, the patience has ended or the gate is closed.
  void wait(Clock::duration patience);

  // Until then, or until the gate is closed.
  void pause(Clock::time_point until);

  // The consumer has worked for so long on the message with this number; 0, from one that does not
  // tell: on the one in flight. False for another one, whose time was up, and for what is no time
  // or longer than the message has been out.
  bool feedback(std::uint64_t seq, double seconds);

  // Waits last no longer, until open().
  void close();
  void open();

  Counts counts() const;

 private:
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  Clock::time_point sent_{};
  std::uint64_t seq_ = 0;
  bool in_flight_ = false;
  bool closed_ = false;
  Counts counts_;
};

}  // namespace asap::ros
