#include "ros/bridge/session.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <numeric>
#include <utility>

namespace asap::ros {
namespace {

using namespace std::chrono_literals;

constexpr auto kTurn = 1s;           // a camera that is silent for longer has lost its turn
constexpr auto kComplainEvery = 1s;  // a refusal is logged
constexpr std::size_t kMarks = 4096;
constexpr std::int64_t kNsOfOneUs = 1000;

std::chrono::nanoseconds to_ns(double latency_ms) {
  return std::chrono::nanoseconds(std::llround(latency_ms * 1e6));
}

std::chrono::microseconds to_us(double us) { return std::chrono::microseconds(std::llround(us)); }

}  // namespace

Session::Session(const Parameters& parameters, Receiver& receiver, Say say, NameOf name_of)
    : receiver_(receiver), say_(std::move(say)), name_of_(std::move(name_of)) {
  check(parameters);
  scheme_config_ = {.latency = to_ns(parameters.latency_ms),
                    .prefer = prefer_of(parameters.prefer)};
  const auto* const when_full =
      std::ranges::find(kWhenFull, std::string_view(parameters.when_full));
  run_config_ = {.capacity = static_cast<std::size_t>(parameters.capacity),
                 .seed = static_cast<std::uint64_t>(parameters.seed),
                 .validator = {.reorder_tolerance = to_us(parameters.reorder_tolerance_us),
                               .warmup_discard = to_us(parameters.warmup_discard_us)},
                 .execution = receiver.execution(),
                 .when_full = static_cast<WhenFull>(when_full - kWhenFull)};
}

Session::~Session() { stop(); }

// ---- messages

std::optional<Refusal> Session::take(const Packet& packet) {
  const auto now = Clock::now();
  const std::lock_guard lock(control_);
  if (stopped_) return {};
  ++messages_;
  if (const auto refusal = refusal_of(packet, now)) {
    refuse(*refusal, packet, now);
    return refusal;
  }
  heard_ = now;
  const PacketReader::Seen seen = reader_.see(packet);
  if (packet.sensor != sensor_) begin(packet.sensor);
  if (seen.lost > 0) pipeline_->upstream_lost(1, seen.lost);
  is_new_epoch_ = is_new_epoch_ || seen.is_new;
  std::optional<std::int64_t> first_us;
  reader_.decode(packet, [&](EventSpan events) {
    if (!first_us) {
      first_us = events.front().t;
      if (std::exchange(is_new_epoch_, false)) pipeline_->begin_epoch(*first_us);
      mark(packet, *first_us + pipeline_->clock_offset_us());
    }
    pipeline_->push(events, now);
  });
  // Again: the pipeline may have found by itself that the clock was set back.
  if (first_us) mark(packet, *first_us + pipeline_->clock_offset_us());
  return {};
}

std::optional<Refusal> Session::refusal_of(const Packet& packet, Clock::time_point now) const {
  if (const auto refusal = ros::refusal_of(packet)) return refusal;
  if (!pipeline_ || now - heard_ > kTurn) return {};
  if (packet.publisher != reader_.publisher()) return Refusal::publisher;
  if (packet.sensor != sensor_) return Refusal::geometry;
  return {};
}

void Session::refuse(Refusal refusal, const Packet& packet, Clock::time_point now) {
  ++refused_[static_cast<std::size_t>(refusal)];
  reader_.refuse(packet);
  if (refusal == Refusal::publisher) other_ = packet.publisher;
  if (now - complained_ < kComplainEvery) return;
  complained_ = now;
  say_(Level::warn, sentence(refusal, packet, name_of_(packet.publisher)));
}

void Session::mark(const Packet& packet, std::int64_t t_us) {
  const std::lock_guard worker(worker_);
  if (frame_id_ != packet.frame_id) frame_id_ = packet.frame_id;
  if (!marks_.empty() && t_us <= marks_.back().t_us) return;
  marks_.push_back({t_us, packet.stamp_ns});
  if (marks_.size() > kMarks) marks_.pop_front();
}

// ---- runs

void Session::begin(const Geometry& sensor) {
  end();
  run_config_.validator.width = static_cast<int>(sensor.width);
  run_config_.validator.height = static_cast<int>(sensor.height);
  receiver_.begin(sensor);
  pipeline_.reset();
  marks_.clear();
  pipeline_ = std::make_unique<Pipeline>(scheme_.emplace(scheme_config_), run_config_);
  thread_ = std::jthread(
      [this] { pipeline_->run([this](const Package& package) { process(package); }); });
  sensor_ = sensor;
  say_(Level::ok, "a sensor of " + std::to_string(sensor.width) + " x " +
                      std::to_string(sensor.height) + " px");
}

void Session::end() {
  if (!pipeline_ || !pipeline_->is_open()) return;
  receiver_.hurry();
  pipeline_->stop();
  thread_.join();
  say_(Level::ok, "run ended: " + sentence(pipeline_->ledger()));
}

void Session::process(const Package& package) {
  std::string what = "no std::exception";
  try {
    return receiver_.process(package, stamp_of(package.t_first()));
  } catch (const std::exception& error) {
    what = error.what();
  } catch (...) {
  }
  std::unique_lock lock(worker_);
  ++failures_;
  if (std::exchange(failure_, what) == what) return;
  lock.unlock();
  say_(Level::error, "process() throws: " + what);
}

// Sensor and host drift apart, so the message counts in which the package began.
std::int64_t Session::stamp_of(std::int64_t t_us) {
  const std::lock_guard lock(worker_);
  while (marks_.size() > 1 && marks_[1].t_us <= t_us) marks_.pop_front();
  return marks_.front().stamp_ns + (t_us - marks_.front().t_us) * kNsOfOneUs;
}

void Session::set(const Parameters& parameters) {
  check(parameters);
  const std::lock_guard lock(control_);
  scheme_config_.latency = to_ns(parameters.latency_ms);
  if (pipeline_) pipeline_->set_latency(scheme_config_.latency);
  receiver_.set(parameters);
}

void Session::stop() {
  const std::lock_guard lock(control_);
  stopped_ = true;
  end();
}

// ---- reports

std::string Session::frame_id() const {
  const std::lock_guard lock(worker_);
  return frame_id_;
}

PipelineStats Session::stats() const {
  const std::lock_guard lock(control_);
  PipelineStats stats;
  if (pipeline_) stats = pipeline_->stats();
  stats.latency_bound_ns = scheme_config_.latency.count();
  stats.stalled = stats.stalled || receiver_.stalled();
  return stats;
}

Session::Report Session::report(const std::string& topic, const std::string& mismatch) {
  const PipelineStats stats = this->stats();
  const std::lock_guard lock(control_);
  Report report{.frame_id = frame_id(), .facts = facts(stats)};
  const std::lock_guard worker(worker_);
  const Ledger& ledger = stats.ledger;
  const auto refused = std::accumulate(refused_.begin(), refused_.end(), std::uint64_t{0});
  const decltype(reported_) counts{{"received", ledger.received},
                                   {"rejected", ledger.rejected},
                                   {"discarded", ledger.discarded},
                                   {"stale", ledger.stale},
                                   {"overflow", ledger.overflow},
                                   {"delivered", ledger.delivered},
                                   {"messages", messages_},
                                   {"refused", refused},
                                   {"failures", failures_},
                                   {"lost", stats.upstream_packets},
                                   {"in_time", stats.latency.within_bound()}};
  auto since = counts;
  for (auto& [name, count] : since) {
    if (count >= reported_[name]) count -= reported_[name];  // else a run of its own
    report.facts.push_back({"last_second." + name, number(count)});
  }
  reported_ = counts;

  // The first that holds is said.
  const auto say = [&report](bool is_so, Level level, const std::string& message) {
    if (is_so && report.level == Level::ok) report.level = level, report.message = message;
  };
  const auto any = [&since](const char* of) { return since.at(of) > 0; };
  const auto count = [&since](const char* of) { return std::to_string(since.at(of)); };
  const auto silent_s = std::chrono::floor<std::chrono::seconds>(Clock::now() - heard_).count();
  const std::string silent = "no message on " + topic;
  const bool all_refused = any("messages") && since.at("refused") == since.at("messages");
  const bool all_rejected = any("received") && since.at("rejected") == since.at("received");
  say(any("failures"), Level::error, "process() throws: " + failure_);
  say(!mismatch.empty(), Level::error, mismatch);
  if (!other_.empty()) {
    say(true, all_refused ? Level::error : Level::warn,
        "two cameras: " + name_of_(reader_.publisher()) + " is heard, " + name_of_(other_) +
            " is refused");
  }
  say(all_refused, Level::error, "all " + count("refused") + " messages refused");
  say(all_rejected, Level::error, "all " + count("rejected") + " events rejected");
  say(stats.stalled, Level::warn, "stalled: the consumer stays away");
  say(messages_ == 0, Level::warn, silent);
  say(!any("messages"), Level::warn, silent + " for " + std::to_string(silent_s) + " s");
  say(!receiver_.is_heard(), Level::warn, "no subscriber of the packages");
  say(any("overflow"), Level::warn, count("overflow") + " events did not fit into the ring");
  say(any("lost"), Level::warn, count("lost") + " messages of the driver are missing");
  say(any("refused"), Level::warn, count("refused") + " messages refused");
  other_.clear();
  return report;
}

Facts Session::facts(const PipelineStats& stats) const {
  const char* const state = stopped_ ? "stopped" : stats.stalled ? "stalled" : "open";
  Facts facts{{"schema_version", "1"},
              text("mode", "live"),
              text("state", state),
              {"source.width", number(std::uint64_t{sensor_.width})},
              {"source.height", number(std::uint64_t{sensor_.height})},
              text("scheme.name", "deadline"),
              text("scheme.prefer", name_of(scheme_config_.prefer))};
  const Facts run = facts_of(stats);
  facts.insert(facts.end(), run.begin(), run.end());
  facts.push_back({"messages.received", number(messages_)});
  for (std::size_t i = 0; i < kRefusals.size(); ++i) {
    facts.push_back({std::string("messages.refused_") + kRefusals[i], number(refused_[i])});
  }
  facts.push_back({"messages.bad_records", number(reader_.bad_records())});
  facts.push_back({"messages.before_start", number(reader_.before_start())});
  facts.push_back({"messages.triggers_lost", number(reader_.triggers())});
  const std::lock_guard worker(worker_);
  facts.push_back({"failures.count", number(failures_)});
  facts.push_back(text("failures.last", failure_));
  const Facts more = receiver_.facts();
  facts.insert(facts.end(), more.begin(), more.end());
  return facts;
}

}  // namespace asap::ros
