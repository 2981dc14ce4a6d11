#include "ros/bridge/feedback_gate.hpp"

namespace asap::ros {

void FeedbackGate::sent(std::uint64_t seq) {
  const std::lock_guard lock(mutex_);
  seq_ = seq;
  in_flight_ = true;
  sent_ = Clock::now();
}

void FeedbackGate::wait(Clock::duration patience) {
  std::unique_lock lock(mutex_);
  changed_.wait_until(lock, sent_ + patience, [this] { return !in_flight_ || closed_; });
  if (in_flight_ && !closed_) {
    ++counts_.timeouts;
    counts_.stalled = true;
  }
  in_flight_ = false;
}

void FeedbackGate::pause(Clock::time_point until) {
  std::unique_lock lock(mutex_);
  changed_.wait_until(lock, until, [this] { return closed_; });
}

bool FeedbackGate::feedback(std::uint64_t seq, double seconds) {
  const std::lock_guard lock(mutex_);
  const std::chrono::duration<double> out = Clock::now() - sent_;
  const bool is_named = in_flight_ && (seq == 0 || seq == seq_);
  if (!(is_named && seconds >= 0.0 && seconds <= out.count())) {  // NaN too
    ++counts_.refused;
    return false;
  }
  ++counts_.taken;
  counts_.stalled = false;
  in_flight_ = false;
  changed_.notify_all();
  return true;
}

void FeedbackGate::close() {
  const std::lock_guard lock(mutex_);
  closed_ = true;
  changed_.notify_all();
}

void FeedbackGate::open() {
  const std::lock_guard lock(mutex_);
  closed_ = false;
}

FeedbackGate::Counts FeedbackGate::counts() const {
  const std::lock_guard lock(mutex_);
  return counts_;
}

}  // namespace asap::ros
