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
constexpr std::size_t kTriggers = 4096;
constexpr double kGoodShare = 0.95;  // of the events, processed in time
constexpr double kBadShare = 0.01;   // of the events, rejected

std::chrono::nanoseconds to_ns(double latency_ms) {
  return std::chrono::nanoseconds(std::llround(latency_ms * 1e6));
}

std::string percent(std::uint64_t part, std::uint64_t whole) {
  const double share = static_cast<double>(part) / static_cast<double>(whole);
  return to_text(std::round(1000 * share) / 10) + " %";
}

std::string milliseconds(double ns) { return to_text(std::round(ns * 1e-4) / 100) + " ms"; }

std::chrono::microseconds to_us(double us) { return std::chrono::microseconds(std::llround(us)); }

}  // namespace

Session::Session(const Parameters& parameters, Receiver& receiver, Say say, NameOf name_of)
    : receiver_(receiver),
      say_(std::move(say)),
      name_of_(std::move(name_of)),
      queue_(static_cast<std::size_t>(parameters.queue)) {
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
  newest_ = now;
  if (const auto refusal = refusal_of(packet, now)) {
    refuse(*refusal, packet, now);
    return refusal;
  }
  note_wait(packet, now);
  heard_ = now;
  const PacketReader::Seen seen = reader_.see(packet);
  try {
    if (packet.sensor != sensor_) begin(packet.sensor);
  } catch (const std::exception& error) {  // the next message tries again
    fail(std::string("no run can begin: ") + error.what());
    return {};
  }
  if (seen.lost > 0) pipeline_->upstream_lost(1, seen.lost);
  is_new_epoch_ = is_new_epoch_ || seen.is_new;
  const auto arrival = now - std::chrono::nanoseconds(std::max<std::int64_t>(packet.waited_ns, 0));
  std::optional<std::int64_t> first_us;
  reader_.decode_all(packet, [&](EventSpan events, std::span<const Trigger> triggers) {
    if (!first_us) {
      first_us = events.empty() ? triggers.front().t : events.front().t;
      if (!triggers.empty()) first_us = std::min(*first_us, triggers.front().t);
      if (std::exchange(is_new_epoch_, false)) pipeline_->begin_epoch(*first_us);
      mark(packet, *first_us + pipeline_->clock_offset_us());
    }
    note(triggers);
    if (!events.empty()) pipeline_->push(events, arrival);
  });
  // Again: the pipeline may have found by itself that the clock was set back.
  if (first_us) mark(packet, *first_us + pipeline_->clock_offset_us());
  taken_ = Clock::now();
  return {};
}

std::optional<Refusal> Session::refusal_of(const Packet& packet, Clock::time_point now) const {
  if (const auto refusal = ros::refusal_of(packet)) return refusal;
  if (!pipeline_) return {};
  const bool is_heard = reader_.is_heard(packet), fits = packet.sensor == sensor_;
  if (is_heard && fits) return {};
  if (now - heard_ > kTurn && (fits || is_next(packet, now))) return {};
  return is_heard ? Refusal::geometry : Refusal::publisher;
}

// One message of a stray does not end the run.
bool Session::is_next(const Packet& packet, Clock::time_point now) const {
  return packet.publisher == other_.publisher && packet.frame_id == other_.frame_id &&
         packet.sensor == other_.sensor && now - other_.at < 2 * kTurn;
}

void Session::refuse(Refusal refusal, const Packet& packet, Clock::time_point now) {
  ++refused_[static_cast<std::size_t>(refusal)];
  reader_.refuse(packet);
  if (refusal == Refusal::publisher || refusal == Refusal::geometry) {
    other_ = {std::string(packet.publisher), std::string(packet.frame_id), packet.sensor, now};
  }
  is_other_ = is_other_ || refusal == Refusal::publisher;
  if (now - complained_ < kComplainEvery) return;
  complained_ = now;
  refusal_ =
      sentence(refusal, packet, named(std::string(packet.publisher), std::string(packet.frame_id)));
  say_(Level::warn, "message refused: " + refusal_);
}

std::string Session::named(const std::string& publisher, const std::string& frame_id) const {
  if (!publisher.empty()) return name_of_(publisher);
  return "a driver in this process with the frame \"" + frame_id + "\"";
}

void Session::note_wait(const Packet& packet, Clock::time_point now) {
  waited_ns_ = std::max(waited_ns_, packet.waited_ns);
  const bool waited = now - std::chrono::nanoseconds(packet.waited_ns) < taken_;
  backlog_ = waited ? backlog_ + 1 : 0;
  max_backlog_ = std::max(max_backlog_, backlog_);
}

void Session::note(std::span<const Trigger> triggers) {
  const std::int64_t offset_us = pipeline_->clock_offset_us();
  const std::lock_guard worker(worker_);
  for (Trigger trigger : triggers) {
    trigger.t += offset_us;
    triggers_.push_back(trigger);
    if (triggers_.size() > kTriggers) triggers_.pop_front();
  }
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
  sensor_ = {};
  run_config_.validator.width = static_cast<int>(sensor.width);
  run_config_.validator.height = static_cast<int>(sensor.height);
  receiver_.begin(sensor);
  pipeline_.reset();
  marks_.clear();
  triggers_.clear();
  std::erase_if(reported_, [](const auto& count) {
    return count.first != "messages" && count.first != "refused" && count.first != "failures";
  });
  latency_ = {};
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
    pass_triggers(package.t_last());
    receiver_.process(package, stamp_of(package.t_first()));
    return scheme_->note(receiver_.stalled());
  } catch (const std::exception& error) {
    what = error.what();
  } catch (...) {
  }
  fail("process() throws: " + what);
}

void Session::pass_triggers(std::int64_t until_us) {
  bool is_lost = false;
  std::unique_lock worker(worker_);
  std::erase_if(triggers_, [&](const Trigger& trigger) {
    if (trigger.t > until_us) return false;
    const bool passes = receiver_.trigger(trigger);
    passed_ += passes;
    is_lost = is_lost || !passes;
    return true;
  });
  is_lost = is_lost && !std::exchange(is_trigger_loss_said_, true);
  worker.unlock();
  if (is_lost) {
    say_(Level::warn, "external triggers do not pass; packages in evt3 have them");
  }
}

void Session::fail(const std::string& what) {
  std::unique_lock lock(worker_);
  ++failures_;
  if (std::exchange(failure_, what) == what) return;
  lock.unlock();
  say_(Level::error, what);
}

// Sensor and host drift apart, so the message counts in which the package began.
std::int64_t Session::stamp_of(std::int64_t t_us) {
  const std::lock_guard lock(worker_);
  while (marks_.size() > 1 && marks_[1].t_us <= t_us) marks_.pop_front();
  return marks_.front().stamp_ns + (t_us - marks_.front().t_us) * 1000;
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

Session::Counts Session::counts_of(const PipelineStats& stats) const {
  const Ledger& ledger = stats.ledger;
  const Rejections& rejected = stats.rejected;
  const std::lock_guard worker(worker_);
  return {{"received", ledger.received},
          {"rejected", ledger.rejected},
          {"discarded", ledger.discarded},
          {"stale", ledger.stale},
          {"overflow", ledger.overflow},
          {"delivered", ledger.delivered},
          {"settled", ledger.received - ledger.pending},
          {"in_time", stats.latency.within_bound()},
          {"nonmonotonic", rejected.nonmonotonic},
          {"out_of_bounds", rejected.out_of_bounds},
          {"bad_polarity", rejected.bad_polarity},
          {"bad_record", rejected.bad_record},
          {"messages", messages_},
          {"refused", std::accumulate(refused_.begin(), refused_.end(), std::uint64_t{0})},
          {"lost", stats.upstream_packets},
          {"failures", failures_}};
}

Session::Report Session::report(const std::string& topic, const std::string& mismatch) {
  const PipelineStats stats = this->stats();
  const std::lock_guard lock(control_);
  Report report{.frame_id = frame_id(), .facts = facts(stats)};
  const Counts counts = counts_of(stats);
  Counts since = counts;
  for (auto& [name, count] : since) {
    count -= reported_[name];
    report.facts.push_back({"last_second." + name, number(count)});
  }
  report.facts.push_back({"last_second.waited_us", number(static_cast<double>(waited_ns_) * 1e-3)});
  if (!mismatch.empty()) report.level = Level::error, report.message = mismatch;
  const std::string late = lateness(since, stats);
  judge(report, since, stats, topic, late);
  const bool is_behind = !late.empty();
  if (is_behind != is_behind_) say_(is_behind ? Level::warn : Level::ok, report.message);
  is_behind_ = is_behind;
  reported_ = counts;
  latency_ = stats.latency;
  is_other_ = false;
  waited_ns_ = 0;
  max_backlog_ = 0;
  return report;
}

// Says the worst; of the equally bad, the first.
void Session::judge(Report& report, const Counts& since, const PipelineStats& stats,
                    const std::string& topic, const std::string& late) const {
  const auto say = [&report](Level level, const std::string& message) {
    if (level > report.level && !message.empty()) report.level = level, report.message = message;
  };
  const auto count = [&since](const char* of) {
    return since.at(of) > 0 ? std::to_string(since.at(of)) : std::string();
  };
  const auto told = [&count](const char* of, const std::string& words) {
    return count(of).empty() ? "" : count(of) + words;
  };
  const bool all_refused = since.at("messages") > 0 && since.at("refused") == since.at("messages");
  const bool all_rejected =
      since.at("received") > 0 && since.at("rejected") == since.at("received");
  const Complaint complaint = receiver_.complaint();
  {
    const std::lock_guard worker(worker_);
    if (!count("failures").empty()) say(Level::error, failure_);
  }
  if (is_other_) {
    say(all_refused ? Level::error : Level::warn,
        "two cameras: " + named(reader_.publisher(), reader_.frame_id()) + " is heard, " +
            named(other_.publisher, other_.frame_id) + " is refused");
  }
  const std::string refused = told("refused", " messages refused: " + refusal_);
  if (all_refused) say(Level::error, refused);
  say(all_rejected ? Level::error : Level::warn, rejection(since));
  if (since.at("messages") == 0) say(Level::warn, silence(topic));
  if (!receiver_.is_heard()) say(Level::warn, "no subscriber of the packages");
  if (stats.stalled) {
    say(complaint.level, complaint.message);
    say(Level::warn, std::string("stalled: ") + receiver_.bottleneck() + " has not finished");
  }
  say(Level::warn, told("overflow", " events did not fit into the ring"));
  say(Level::warn, late);
  say(complaint.level, complaint.message);
  say(Level::warn, missing(since));
  say(Level::warn, refused);
  if (report.level == Level::ok && !complaint.message.empty()) {
    report.message += "; " + complaint.message;
  }
}

std::string Session::silence(const std::string& topic) const {
  const auto s = std::chrono::floor<std::chrono::seconds>(Clock::now() - newest_).count();
  const std::string silent = "no message on " + topic;
  return messages_ == 0 ? silent : silent + " for " + std::to_string(s) + " s";
}

std::string Session::rejection(const Counts& since) const {
  std::uint64_t bad = 0;
  std::string reasons;
  for (const char* reason : {"nonmonotonic", "out_of_bounds", "bad_polarity", "bad_record"}) {
    const std::uint64_t count = since.at(reason);
    bad += count;
    if (count > 0) reasons += (reasons.empty() ? "" : ", ") + std::to_string(count) + " " + reason;
  }
  const std::uint64_t received = since.at("received");
  if (static_cast<double>(bad) <= kBadShare * static_cast<double>(received)) return {};
  return percent(bad, received) + " of the events rejected: " + reasons;
}

// In the words of Python's verdict.
std::string Session::lateness(const Counts& since, const PipelineStats& stats) const {
  const std::uint64_t settled = since.at("settled"), in_time = since.at("in_time");
  if (static_cast<double>(in_time) >= kGoodShare * static_cast<double>(settled)) return {};
  const bool is_machine = waited_ns_ > stats.latency_bound_ns / 2;
  const double p99_ns = stats.latency.since(latency_).quantile_ns(0.99);
  return std::string("Bottleneck: ") + (is_machine ? "this machine" : receiver_.bottleneck()) +
         ". " + percent(in_time, settled) + " processed in time, p99 " + milliseconds(p99_ns) +
         " of " + milliseconds(static_cast<double>(stats.latency_bound_ns)) +
         (is_machine ? "; messages waited for " + milliseconds(static_cast<double>(waited_ns_)) +
                           " in the middleware"
                     : "");
}

std::string Session::missing(const Counts& since) const {
  if (since.at("lost") == 0) return {};
  const bool is_own = max_backlog_ >= queue_ / 2 || reader_.publisher().empty();
  return std::to_string(since.at("lost")) + " messages are missing: lost " +
         (is_own ? "in the node's own queue of " + std::to_string(queue_)
                 : "by the driver or the network");
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
  const std::lock_guard worker(worker_);
  facts.push_back({"triggers.received", number(reader_.triggers())});
  facts.push_back({"triggers.passed", number(passed_)});
  facts.push_back({"failures.count", number(failures_)});
  facts.push_back(text("failures.last", failure_));
  const Facts more = receiver_.facts();
  facts.insert(facts.end(), more.begin(), more.end());
  return facts;
}

}  // namespace asap::ros
