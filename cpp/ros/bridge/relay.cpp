#include "ros/bridge/relay.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

namespace asap::ros {
namespace {

using Seconds = std::chrono::duration<double>;

constexpr Seconds kLook{0.1};           // how often a pause heeds another rate bound
constexpr double kHeldShare = 0.1;      // of the bound: a package is held up
constexpr double kHeldPackages = 0.01;  // of the packages: the 99 % quantile is

FeedbackGate::Clock::duration clock_time(Seconds time) {
  return std::chrono::duration_cast<FeedbackGate::Clock::duration>(time);
}

// For how long this thread has been ready without a processor; none where the system does not tell.
std::optional<std::int64_t> thread_held_ns() {
  long long ran_ns = 0, held_ns = 0;
  std::FILE* const file = std::fopen("/proc/thread-self/schedstat", "r");
  if (file == nullptr) return {};
  const bool is_told = std::fscanf(file, "%lld %lld", &ran_ns, &held_ns) == 2;
  std::fclose(file);
  return is_told ? std::optional<std::int64_t>(held_ns) : std::nullopt;
}

std::string in_words(std::size_t count) {
  return std::to_string(count) + (count == 1 ? " consumer gives" : " consumers give");
}

}  // namespace

Relay::Relay(const Parameters& parameters, Publish publish, Count count, NameOf name_of)
    : encoding_(parameters.encoding),
      waits_(parameters.feedback != "none"),
      publish_(std::move(publish)),
      count_(std::move(count)),
      name_of_(std::move(name_of)) {
  check(parameters);
  Relay::set(parameters);
  if (encoding_ != kDecoded) writer_.emplace(encoding_);
  message_.encoding = encoding_;
}

void Relay::set(const Parameters& parameters) {
  gate_.set_patience(clock_time(Seconds(parameters.feedback_timeout_ms * 1e-3)));
  rate_bound_ = parameters.rate_bound;
  latency_ms_ = parameters.latency_ms;
}

Facts Relay::facts() const {
  const FeedbackGate::Counts counts = gate_.counts();
  return {{"feedback.taken", number(counts.taken)},
          {"feedback.refused", number(counts.refused)},
          {"feedback.timeouts", number(counts.timeouts)},
          {"feedback.consumers", number(counts.consumers)},
          {"feedback.stalled", counts.stalled ? "true" : "false"},
          {"feedback.unseen", number(unseen_.load())},
          {"feedback.held", number(held_.load())}};
}

const char* Relay::bottleneck() const {
  return rate_bound_ > 0 ? "the rate bound" : "the algorithm";
}

Complaint Relay::complaint() {
  const FeedbackGate::Counts counts = gate_.counts();
  const FeedbackGate::Counts before = std::exchange(complained_, counts);
  Consumers consumers = count_();
  if (!waits_) consumers.answering = 0;
  const auto since = [](const auto& count, std::uint64_t& then) {
    return static_cast<double>(count - std::exchange(then, count));
  };
  const double held = since(held_, complained_held_), unseen = since(unseen_, complained_unseen_);
  if (counts.refused > before.refused) {
    return {Level::warn, "feedback refused: " + counts.refusal};
  }
  if (counts.stalled || counts.timeouts > before.timeouts) {
    return {Level::warn, "stalled: no feedback for " + to_text(std::floor(counts.stalled_s)) +
                             " s; until it comes, a small package per feedback_timeout_ms"};
  }
  // One that has gone is not on the topic any more.
  std::string left_out;
  for (std::size_t i = counts.left_out.size(), here = counts.consumers; i-- > 0;) {
    if (++here > consumers.answering) break;
    left_out += (left_out.empty() ? "" : ", ") + name_of_(counts.left_out[i]);
  }
  if (!left_out.empty()) {
    return {Level::warn, "left out until it gives feedback: " + left_out +
                             "; it gave none within feedback_timeout_ms, and what it loses is not "
                             "counted"};
  }
  Complaint quiet;
  if (consumers.heard > consumers.answering) {
    const bool is_chosen = !waits_ || consumers.answering > 0;
    quiet = {is_chosen ? Level::ok : Level::warn, in_words(consumers.heard - consumers.answering) +
                                                      " no feedback: what it loses is not counted"};
  }
  if (quiet.level == Level::ok && held > kHeldPackages * unseen) {
    return {Level::warn, "starved: " + to_text(std::round(1000 * held / unseen) / 10) +
                             " % of the packages waited for a processor, a tenth of the bound or "
                             "longer; so do consumers here, unseen without feedback"};
  }
  return quiet;
}

void Relay::begin(const Geometry& sensor) {
  message_.sensor = sensor;
  held_ns_.reset();  // of another thread
  gate_.open();
}

bool Relay::trigger(const Trigger& trigger) {
  if (encoding_ != "evt3" || trigger.id >= 16) return false;
  triggers_.push_back(trigger);
  return true;
}

void Relay::process(const Package& package, std::int64_t stamp_ns) {
  const auto start = FeedbackGate::Clock::now();
  const Consumers consumers = count_();
  const bool waits = waits_ && consumers.heard > 0 && consumers.answering > 0;
  if (waits) {
    held_ns_.reset();
  } else {
    gate_.skip();
    note_held();
  }
  message_.stamp_ns = stamp_ns;
  for (EventSpan rest = package.events; !rest.empty();) {
    PackageWriter::Written written{.events = rest.size()};
    if (writer_) written = writer_->write(rest, message_.bytes, triggers_);
    message_.time_base = written.time_base;
    message_.events = rest.first(written.events);
    ++message_.seq;
    if (waits) gate_.sent(message_.seq);
    publish_(message_);
    rest = rest.subspan(written.events);
    triggers_.clear();
  }
  if (waits) gate_.wait();
  for (;;) {
    const double bound = rate_bound_;
    const auto now = FeedbackGate::Clock::now();
    const Seconds rest =
        Seconds(static_cast<double>(package.events.size()) / bound) - (now - start);
    if (!(bound > 0 && rest > Seconds(0))) break;
    if (!gate_.pause(now + clock_time(std::min(rest, kLook)))) break;
  }
}

void Relay::note_held() {
  const auto now_ns = thread_held_ns();
  const auto before_ns = std::exchange(held_ns_, now_ns);
  if (!now_ns || !before_ns) return;
  ++unseen_;
  held_ += static_cast<double>(*now_ns - *before_ns) > kHeldShare * latency_ms_ * 1e6;
}

}  // namespace asap::ros
