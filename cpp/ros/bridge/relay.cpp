#include "ros/bridge/relay.hpp"

#include <utility>

namespace asap::ros {
namespace {

using Seconds = std::chrono::duration<double>;

FeedbackGate::Clock::duration clock_time(Seconds time) {
  return std::chrono::duration_cast<FeedbackGate::Clock::duration>(time);
}

}  // namespace

Relay::Relay(const Parameters& parameters, Publish publish, IsHeard is_heard)
    : encoding_(parameters.encoding),
      waits_(parameters.feedback != "none"),
      publish_(std::move(publish)),
      is_heard_(std::move(is_heard)) {
  check(parameters);
  Relay::set(parameters);
  if (encoding_ != kDecoded) writer_.emplace(encoding_);
  message_.encoding = encoding_;
}

void Relay::set(const Parameters& parameters) {
  feedback_timeout_ms_ = parameters.feedback_timeout_ms;
  rate_bound_ = parameters.rate_bound;
}

Facts Relay::facts() const {
  const FeedbackGate::Counts counts = gate_.counts();
  return {{"feedback.taken", number(counts.taken)},
          {"feedback.refused", number(counts.refused)},
          {"feedback.timeouts", number(counts.timeouts)},
          {"feedback.stalled", counts.stalled ? "true" : "false"}};
}

void Relay::begin(const Geometry& sensor) {
  message_.sensor = sensor;
  gate_.open();
}

void Relay::process(const Package& package, std::int64_t stamp_ns) {
  const auto start = FeedbackGate::Clock::now();
  const bool waits = waits_ && is_heard_();
  message_.stamp_ns = stamp_ns;
  for (EventSpan rest = package.events; !rest.empty();) {
    PackageWriter::Written written{.events = rest.size()};
    if (writer_) written = writer_->write(rest, message_.bytes);
    message_.time_base = written.time_base;
    message_.events = rest.first(written.events);
    ++message_.seq;
    if (waits) gate_.sent(message_.seq);
    publish_(message_);
    rest = rest.subspan(written.events);
  }
  if (waits) gate_.wait(clock_time(Seconds(feedback_timeout_ms_ * 1e-3)));
  if (const double bound = rate_bound_; bound > 0) {
    gate_.pause(start + clock_time(Seconds(static_cast<double>(package.events.size()) / bound)));
  }
}

}  // namespace asap::ros
