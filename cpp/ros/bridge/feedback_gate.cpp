#include "ros/bridge/feedback_gate.hpp"

#include <algorithm>
#include <utility>

#include "ros/bridge/facts.hpp"

namespace asap::ros {

void FeedbackGate::set_patience(Clock::duration patience) {
  const std::lock_guard lock(mutex_);
  patience_ = patience;
  changed_.notify_all();
}

void FeedbackGate::sent(std::uint64_t seq) {
  const std::lock_guard lock(mutex_);
  seq_ = seq;
  in_flight_ = true;
  for (Consumer& one : consumers_) one.has_finished = false;
  sent_ = Clock::now();
}

void FeedbackGate::wait() {
  std::unique_lock lock(mutex_);
  while (!is_finished() && !closed_ && Clock::now() < sent_ + patience_) {
    changed_.wait_until(lock, sent_ + patience_);
  }
  in_flight_ = false;
  if (closed_) return;
  if (!counts_.stalled) stalled_since_ = sent_;
  counts_.stalled = !is_finished();
  if (!counts_.stalled) return;
  ++counts_.timeouts;
  std::erase_if(consumers_, [this](const Consumer& one) {
    if (!one.has_finished) counts_.left_out.push_back(one.id);
    return !one.has_finished;
  });
}

void FeedbackGate::skip() {
  const std::lock_guard lock(mutex_);
  counts_.stalled = false;
}

bool FeedbackGate::is_finished() const {
  return !consumers_.empty() && std::ranges::all_of(consumers_, &Consumer::has_finished);
}

bool FeedbackGate::pause(Clock::time_point until) {
  std::unique_lock lock(mutex_);
  return !changed_.wait_until(lock, until, [this] { return closed_; });
}

FeedbackGate::Consumer& FeedbackGate::consumer(std::string_view id) {
  const auto known = std::ranges::find(consumers_, id, &Consumer::id);
  if (known != consumers_.end()) return *known;
  std::erase(counts_.left_out, id);
  return consumers_.emplace_back(Consumer{std::string(id)});
}

bool FeedbackGate::refuse(std::string reason) {
  ++counts_.refused;
  counts_.refusal = std::move(reason);
  return false;
}

bool FeedbackGate::feedback(std::string_view id, std::uint64_t seq, double seconds) {
  const std::lock_guard lock(mutex_);
  const std::chrono::duration<double> out = Clock::now() - sent_;
  const std::string number = "seq = " + std::to_string(seq);
  const std::string time = "time = " + to_text(seconds);
  if (!(seconds >= 0.0)) return refuse(time + ": must be seconds, 0 or more");  // NaN too
  if (seq > seq_) {
    return refuse(number + ": the newest package has " + std::to_string(seq_) +
                  "; give the seq of the package's message");
  }
  const bool is_named = seq == 0 || seq == seq_;
  if (is_named && in_flight_ && seconds > out.count()) {
    return refuse(time + ": the package left " + to_text(out.count()) + " s ago; give seconds");
  }
  if (seq == 0 && !in_flight_) return refuse(number + ": no package is in flight");
  Consumer& its = consumer(id);
  if (!is_named || !in_flight_) return refuse(number + ": too late, its time was up");
  if (its.has_finished) return refuse(number + ": finished before; give feedback once");
  its.has_finished = true;
  ++counts_.taken;
  if (is_finished()) changed_.notify_all();
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
  Counts counts = counts_;
  counts.consumers = consumers_.size();
  const std::chrono::duration<double> stalled = Clock::now() - stalled_since_;
  counts.stalled_s = counts.stalled ? stalled.count() : 0.0;
  return counts;
}

}  // namespace asap::ros
