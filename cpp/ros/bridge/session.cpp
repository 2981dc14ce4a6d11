#include "ros/bridge/session.hpp"

#include <chrono>
#include <cmath>
#include <exception>
#include <numeric>
#include <utility>

namespace asap::ros {
namespace {

std::chrono::nanoseconds to_ns(double latency_ms) {
  return std::chrono::nanoseconds(std::llround(latency_ms * 1e6));
}
constexpr std::int64_t kNsOfOneUs = 1000;
constexpr std::int64_t kMostBetweenMarks_us = 1'000'000;

}  // namespace

Session::Session(const Parameters& parameters, Receiver& receiver, Say say)
    : receiver_(receiver), say_(std::move(say)) {
  check(parameters);
  scheme_config_ = {.latency = to_ns(parameters.latency_ms),
                    .prefer = prefer_of(parameters.prefer)};
}

Session::~Session() { stop(); }

std::optional<Refusal> Session::take(const Packet& packet, std::int64_t stamp_ns) {
  const auto arrival = std::chrono::steady_clock::now();
  const std::lock_guard lock(control_);
  if (stopped_) return {};
  ++messages_;
  const auto refuse = [this](Refusal refusal) {
    ++refused_[static_cast<std::size_t>(refusal)];
    return refusal;
  };
  const PacketReader::Seen seen = reader_.see(packet);
  if (seen.refusal) return refuse(*seen.refusal);
  if (packet.sensor != sensor_) {
    if (!seen.is_new) return refuse(Refusal::geometry);  // of a camera that is not the one in use
    begin(packet.sensor);
  }
  if (seen.lost > 0) pipeline_->upstream_lost(1, seen.lost);
  bool is_marked = false;
  reader_.decode(packet, [&](EventSpan events) {
    if (!std::exchange(is_marked, true)) {
      const std::lock_guard worker(worker_);
      mark_ = {stamp_ns, events.front().t};
    }
    pipeline_->push(events, arrival);
  });
  return {};
}

void Session::begin(const Geometry& sensor) {
  end();
  const auto width = static_cast<int>(sensor.width), height = static_cast<int>(sensor.height);
  receiver_.begin(sensor);
  pipeline_.reset();
  pipeline_ = std::make_unique<Pipeline>(scheme_.emplace(scheme_config_),
                                         RunConfig{.validator = {.width = width, .height = height},
                                                   .execution = receiver_.execution()});
  thread_ = std::jthread(
      [this] { pipeline_->run([this](const Package& package) { process(package); }); });
  sensor_ = sensor;
  say_("a sensor of " + std::to_string(width) + " x " + std::to_string(height) + " px");
}

void Session::end() {
  if (!pipeline_ || !pipeline_->is_open()) return;
  receiver_.hurry();
  pipeline_->stop();
  thread_.join();
  say_("run ended: " + sentence(pipeline_->ledger()));
}

void Session::process(const Package& package) {
  try {
    receiver_.process(package, stamp_of(package.t_first()));
  } catch (const std::exception& error) {
    const std::lock_guard lock(worker_);
    ++failures_;
    failure_ = error.what();
  }
}

// Sensor and host drift apart, so the last message counts; a clock that was reset says nothing.
std::int64_t Session::stamp_of(std::int64_t t_us) const {
  const std::lock_guard lock(worker_);
  const std::int64_t since_us = t_us - mark_.t_us;
  const bool is_near = since_us > -kMostBetweenMarks_us && since_us < kMostBetweenMarks_us;
  return mark_.stamp_ns + (is_near ? since_us * kNsOfOneUs : 0);
}

void Session::set_latency(double latency_ms) {
  const std::lock_guard lock(control_);
  const std::chrono::nanoseconds latency = to_ns(latency_ms);
  checked_latency_ns(latency);
  scheme_config_.latency = latency;
  if (pipeline_) pipeline_->set_latency(latency);
}

void Session::stop() {
  const std::lock_guard lock(control_);
  stopped_ = true;
  end();
}

PipelineStats Session::stats() const {
  const std::lock_guard lock(control_);
  if (!pipeline_) {
    PipelineStats none;
    none.latency_bound_ns = checked_latency_ns(scheme_config_.latency);
    return none;
  }
  PipelineStats stats = pipeline_->stats();
  stats.stalled = stats.stalled || receiver_.stalled();
  return stats;
}

std::string Session::trouble(std::string_view topic) {
  const PipelineStats stats = this->stats();
  const std::lock_guard lock(control_);
  const auto refused = std::accumulate(refused_.begin(), refused_.end(), std::uint64_t{0});
  std::array<std::uint64_t, 3> since{stats.ledger.overflow, stats.upstream_packets, refused};
  for (std::size_t i = 0; i < since.size(); ++i) {
    const std::uint64_t told = std::exchange(told_[i], since[i]);
    if (since[i] >= told) since[i] -= told;  // else a run of its own
  }
  if (messages_ == 0) return "no message on " + std::string(topic);
  if (stats.stalled) return "stalled: the consumer stays away";
  if (since[0] > 0) return std::to_string(since[0]) + " events did not fit into the ring";
  if (since[1] > 0) return std::to_string(since[1]) + " messages of the driver are missing";
  if (since[2] > 0) return std::to_string(since[2]) + " messages refused";
  return "";
}

Facts Session::facts() const {
  const PipelineStats stats = this->stats();
  const std::lock_guard lock(control_);
  const char* const state = stopped_ ? "stopped" : stats.stalled ? "stalled" : "open";
  Facts facts{{"schema_version", "1"},
              {"mode", quoted("live")},
              {"state", quoted(state)},
              {"source.width", number(std::uint64_t{sensor_.width})},
              {"source.height", number(std::uint64_t{sensor_.height})},
              {"scheme.name", quoted("deadline")},
              {"scheme.prefer", quoted(name_of(scheme_config_.prefer))}};
  const Facts run = facts_of(stats);
  facts.insert(facts.end(), run.begin(), run.end());
  facts.emplace_back("messages.received", number(messages_));
  for (std::size_t i = 0; i < kRefusals.size(); ++i) {
    facts.emplace_back(std::string("messages.refused_") + kRefusals[i], number(refused_[i]));
  }
  facts.emplace_back("messages.bad_records", number(reader_.bad_records()));
  facts.emplace_back("messages.before_start", number(reader_.before_start()));
  const std::lock_guard worker(worker_);
  facts.emplace_back("failures.count", number(failures_));
  facts.emplace_back("failures.last", quoted(failure_));
  return facts;
}

}  // namespace asap::ros
