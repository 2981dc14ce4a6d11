#include "asap/runner/pipeline.hpp"

#include <stdexcept>

namespace asap {
namespace {

constexpr std::chrono::nanoseconds kPollEvery = std::chrono::milliseconds(20);

}  // namespace

// The consumer's side has one guest at a time.
class Pipeline::Working {
 public:
  explicit Working(Pipeline& pipeline) : pipeline_(pipeline) {
    if (pipeline_.consuming_.exchange(true, std::memory_order_acq_rel)) {
      throw std::logic_error("pipeline: another thread consumes; stop() it first");
    }
  }
  ~Working() { pipeline_.consuming_.store(false, std::memory_order_release); }
  Working(const Working&) = delete;
  Working& operator=(const Working&) = delete;

 private:
  Pipeline& pipeline_;
};

Pipeline::Pipeline(Scheme& scheme, RunConfig config)
    : scheme_(scheme), config_(config), run_(std::make_unique<LiveRun>(scheme, config)) {
  door_.open();
}

bool Pipeline::push(EventSpan events, Arrival arrival) {
  const PushDoor::Visit visit(door_);
  if (!visit.inside()) return false;
  run_->push(events, arrival);
  return true;
}

void Pipeline::upstream_lost(std::uint64_t marks, std::uint64_t packets) noexcept {
  upstream_marks_.fetch_add(marks, std::memory_order_relaxed);
  upstream_packets_.fetch_add(packets, std::memory_order_relaxed);
}

Pipeline::Next Pipeline::next(Package& package, std::chrono::nanoseconds patience) {
  const Working working(*this);
  if (config_.execution != Execution::whole) {
    throw std::logic_error("pipeline: next() needs .execution = Execution::whole; or use run()");
  }
  if (has_package_) run_->loop().complete(package_);
  has_package_ = false;
  const Next next = run_->loop().next(package_, patience);
  has_package_ = next == Next::package;
  if (next == Next::ended) run_->finish();
  if (has_package_) package = package_;
  return next;
}

void Pipeline::complete() {
  const Working working(*this);
  if (has_package_) run_->loop().complete(package_);
  has_package_ = false;
}

void Pipeline::abandon() {
  stop(false);
  if (consuming_.exchange(true, std::memory_order_acq_rel)) return;  // it will see the end itself
  has_package_ = false;
  run_->finish();
  consuming_.store(false, std::memory_order_release);
}

void Pipeline::run(const Consumer& consumer, const Poll& poll) {
  const Working working(*this);
  ConsumerLoop& loop = run_->loop();
  auto polled = std::chrono::steady_clock::now();
  try {
    for (Package package;;) {
      const Next next = loop.next(package, kPollEvery);
      if (next == Next::ended) return run_->finish();
      if (next == Next::package) loop.work(package, consumer);
      if (!poll) continue;
      const auto now = std::chrono::steady_clock::now();
      if (now - polled < kPollEvery) continue;
      polled = now;
      poll();
    }
  } catch (...) {
    stop(false);
    run_->finish();
    throw;
  }
}

void Pipeline::flush() {
  const std::lock_guard lock(control_);
  run_->loop().flush();
}

void Pipeline::stop(bool drain) {
  const std::lock_guard lock(control_);
  const bool was_open = door_.is_open();
  door_.close();
  if (was_open) run_->close();
  if (!drain) run_->loop().abandon();
}

void Pipeline::start() {
  const Working working(*this);
  const std::lock_guard lock(control_);
  if (door_.is_open()) return;
  if (has_package_) throw std::logic_error("pipeline: a package is in work; complete() it first");
  run_.reset();  // its memory first
  run_ = std::make_unique<LiveRun>(scheme_, config_);
  upstream_marks_ = 0;
  upstream_packets_ = 0;
  door_.open();
}

Ledger Pipeline::ledger() const {
  const std::lock_guard lock(control_);
  return run_->ledger();
}

PipelineStats Pipeline::stats() const {
  const std::lock_guard lock(control_);
  const Telemetry& telemetry = run_->telemetry();
  return {.ledger = run_->ledger(),
          .rejected = run_->rejected(),
          .latency = telemetry.latency,
          .packages = telemetry.log.totals(),
          .elapsed_ns = run_->elapsed_ns(),
          .clock_resets = run_->clock_resets(),
          .upstream_marks = upstream_marks_.load(std::memory_order_relaxed),
          .upstream_packets = upstream_packets_.load(std::memory_order_relaxed),
          .open = door_.is_open()};
}

}  // namespace asap
