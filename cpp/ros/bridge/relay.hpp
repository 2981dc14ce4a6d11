// Relay: the receiver that publishes packages, as messages of the middleware. The consumer of the
// packages is the algorithm whose cost counts: with feedback, the next package waits until it has
// finished; without, a package costs what publishing takes, or what the rate bound allows.
// What a consumer that gives no feedback loses is not counted, and complaint() says so. Nor is its
// time: where this thread has to wait for a processor, complaint() says that the consumer has to.
//
// process() is the session's thread's, the rest any thread's.
#pragma once

#include <atomic>
#include <cstddef>
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

// The consumers at the topics: how many take the packages, how many of them can give feedback.
struct Consumers {
  std::size_t heard = 0;
  std::size_t answering = 0;
};

class Relay final : public Receiver {
 public:
  using Publish = std::function<void(Message&)>;
  using Count = std::function<Consumers()>;
  using NameOf = std::function<std::string(std::string_view consumer)>;

  // `count`: feedback is waited for only where a consumer can give it. `name_of` names one in a
  // complaint. Throws std::invalid_argument for parameters that are none.
  Relay(
      const Parameters& parameters, Publish publish, Count count,
      NameOf name_of = [](std::string_view consumer) { return std::string(consumer); });

  // This consumer has worked for so long on the message with this number, see FeedbackGate; false:
  // refused.
  bool feedback(std::string_view consumer, std::uint64_t seq, double seconds) {
    return gate_.feedback(consumer, seq, seconds);
  }
  FeedbackGate::Counts feedbacks() const { return gate_.counts(); }

  void begin(const Geometry& sensor) override;
  bool trigger(const Trigger& trigger) override;
  void process(const Package& package, std::int64_t stamp_ns) override;
  void hurry() noexcept override { gate_.close(); }
  bool is_heard() const override { return count_().heard > 0; }
  bool stalled() const override { return gate_.counts().stalled; }
  const char* bottleneck() const override;
  Complaint complaint() override;
  Facts facts() const override;
  void set(const Parameters& parameters) override;

 private:
  void note_held();

  const std::string encoding_;
  const bool waits_;  // for feedback
  const Publish publish_;
  const Count count_;
  const NameOf name_of_;
  std::atomic<double> rate_bound_;
  FeedbackGate gate_;
  FeedbackGate::Counts complained_;  // at the last complaint()
  std::atomic<double> latency_ms_;
  std::optional<std::int64_t> held_ns_;  // this thread up to its last package without feedback
  std::atomic<std::uint64_t> unseen_ = 0, held_ = 0;  // such packages; held up, of these
  std::uint64_t complained_unseen_ = 0, complained_held_ = 0;
  std::optional<PackageWriter> writer_;  // none: the middleware encodes
  Message message_;
  std::vector<Trigger> triggers_;  // of the next package
};

}  // namespace asap::ros
