// Relay: the receiver that publishes packages, as messages of the middleware. The consumer of the
// packages is the algorithm whose cost counts: with feedback, the next package waits until it has
// finished; without, a package costs what publishing takes, or what the rate bound allows.
//
// process() is the session's thread's, the rest any thread's.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ros/bridge/feedback_gate.hpp"
#include "ros/bridge/package_writer.hpp"
#include "ros/bridge/parameters.hpp"
#include "ros/bridge/session.hpp"

namespace asap::ros {

// A message to publish. Its bytes may be moved from.
struct Message {
  Geometry sensor{};
  std::int64_t stamp_ns = 0;
  std::uint64_t seq = 0;        // the first one has 1
  std::uint64_t time_base = 0;  // ns
  std::string_view encoding{};
  std::vector<std::uint8_t> bytes{};
  EventSpan events{};  // the same as events
};

class Relay final : public Receiver {
 public:
  using Publish = std::function<void(Message&)>;
  using IsHeard = std::function<bool()>;

  // `is_heard`: whether there is a consumer; without one no feedback is waited for. Throws
  // std::invalid_argument for parameters that are none.
  Relay(const Parameters& parameters, Publish publish, IsHeard is_heard);

  // The consumer has worked for so long on the message with this number, see FeedbackGate; false:
  // refused.
  bool feedback(std::uint64_t seq, double seconds) { return gate_.feedback(seq, seconds); }
  FeedbackGate::Counts feedbacks() const { return gate_.counts(); }

  void begin(const Geometry& sensor) override;
  void process(const Package& package, std::int64_t stamp_ns) override;
  void hurry() noexcept override { gate_.close(); }
  bool is_heard() const override { return is_heard_(); }
  bool stalled() const override { return gate_.counts().stalled; }
  Facts facts() const override;
  void set(const Parameters& parameters) override;

 private:
  const std::string encoding_;
  const bool waits_;  // for feedback
  const Publish publish_;
  const IsHeard is_heard_;
  std::atomic<double> feedback_timeout_ms_;
  std::atomic<double> rate_bound_;
  FeedbackGate gate_;
  std::optional<PackageWriter> writer_;  // none: the middleware encodes
  Message message_;
};

}  // namespace asap::ros
