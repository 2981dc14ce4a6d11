// FeedbackGate: where the worker waits for the consumers of its packages to say that they have
// finished the message in flight. There is at most one. Each consumer that has given feedback is
// waited for, so the slowest sets the pace, until its time is up once.
//
// sent(), wait() and pause() are the worker's; the rest any thread's. O(consumers).
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

namespace asap::ros {

class FeedbackGate {
 public:
  using Clock = std::chrono::steady_clock;

  struct Counts {
    std::uint64_t taken = 0;
    std::uint64_t refused = 0;            // no time, or of no package in flight
    std::uint64_t timeouts = 0;           // packages that a consumer did not finish in time
    std::uint64_t consumers = 0;          // that are waited for
    std::vector<std::string> left_out{};  // those whose time was up, until they give feedback again
    bool stalled = false;                 // the last package was such a one
    double stalled_s = 0;                 // since the first of them in a row was sent
    std::string refusal{};                // why, the last time
  };

  // How long a package waits for feedback; from now on, also for the one in flight.
  void set_patience(Clock::duration patience);

  // The message with this number, 1 or more, is about to leave; a package has one or several.
  void sent(std::uint64_t seq);

  // Until the feedback for it has come, the patience has ended or the gate is closed.
  void wait();

  // Instead of both, where no consumer gives feedback.
  void skip();

  // Until then. False: the gate is closed.
  bool pause(Clock::time_point until);

  // This consumer (any bytes that tell consumers apart) has worked for so long on the message with
  // this number; 0, from one that does not tell: on the one in flight. False for another one, whose
  // time was up, and for what is no time or longer than the message has been out.
  bool feedback(std::string_view consumer, std::uint64_t seq, double seconds);

  // Waits last no longer, until open().
  void close();
  void open();

  Counts counts() const;

 private:
  struct Consumer {
    std::string id;
    bool has_finished = false;
  };

  Consumer& consumer(std::string_view id);
  bool is_finished() const;
  bool refuse(std::string reason);

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  Clock::duration patience_ = std::chrono::seconds(1);
  Clock::time_point sent_{};
  Clock::time_point stalled_since_{};
  std::uint64_t seq_ = 0;
  bool in_flight_ = false;
  bool closed_ = false;
  std::vector<Consumer> consumers_;
  Counts counts_;
};

}  // namespace asap::ros
