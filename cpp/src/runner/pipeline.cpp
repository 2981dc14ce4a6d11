#include "asap/runner/pipeline.hpp"

#include <stdexcept>
#include <utility>

#include "asap/schemes/deadline.hpp"

namespace asap {
namespace {

thread_local const Pipeline* worker_of = nullptr;  // whose worker this thread is

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
    : scheme_(scheme),
      config_(std::move(config)),
      latency_bound_ns_(asap::latency_bound_ns(config_, scheme)),
      run_(std::make_unique<LiveRun>(scheme, config_)) {
  door_.open();
}

Pipeline::Pipeline(RunConfig config, Consumer algorithm)
    : Pipeline(std::make_unique<Deadline>(
                   DeadlineConfig{.latency_ms = config.latency_us.value_or(10'000.0) * 1e-3}),
               config, std::move(algorithm)) {}

Pipeline::Pipeline(std::unique_ptr<Scheme> scheme, RunConfig config, Consumer algorithm)
    : own_scheme_(std::move(scheme)),
      scheme_(*own_scheme_),
      config_(std::move(config)),
      latency_bound_ns_(asap::latency_bound_ns(config_, scheme_)),
      run_(std::make_unique<LiveRun>(scheme_, config_)),
      algorithm_(std::move(algorithm)) {
  if (!algorithm_) throw std::invalid_argument("algorithm: none; give what the events are for");
  door_.open();
  set_to_work();
}

Pipeline::~Pipeline() {
  stop(false);
  door_.wait_until_empty();
  if (worker_.joinable()) worker_.join();
}

void Pipeline::set_to_work() {
  works_ = true;
  try {
    worker_ = std::thread([this] {
      worker_of = this;
      try {
        run(algorithm_);
      } catch (...) {
        error_ = std::current_exception();
      }
      works_ = false;
      works_.notify_all();
    });
  } catch (...) {  // no thread to be had
    works_ = false;
    works_.notify_all();
    abandon();
    throw;
  }
}

void Pipeline::join() {
  require_another_thread();
  works_.wait(true);
  const std::lock_guard lock(worker_control_);
  if (!works_) end_work();  // else a new run has begun
}

void Pipeline::require_another_thread() const {
  if (worker_of != this) return;
  throw std::logic_error("pipeline: the worker cannot wait for itself; stop() is enough");
}

void Pipeline::end_work() {
  if (!worker_.joinable()) return;
  worker_.join();
  if (error_) std::rethrow_exception(std::exchange(error_, {}));
}

bool Pipeline::push(EventSpan events, Arrival arrival, const Poll& poll) {
  if (!door_.enter()) return false;
  struct Leave {
    Pipeline& pipeline;
    ~Leave() {
      pipeline.door_.leave([this] { pipeline.run_->close(); });
    }
  } leave{*this};
  run_->push(events, arrival, poll);
  return true;
}

void Pipeline::upstream_lost(std::uint64_t marks, std::uint64_t packets) noexcept {
  upstream_marks_.fetch_add(marks, std::memory_order_relaxed);
  upstream_packets_.fetch_add(packets, std::memory_order_relaxed);
}

Pipeline::Next Pipeline::next(Package& package, std::chrono::nanoseconds patience,
                              const Poll& poll) {
  const Working working(*this);
  if (config_.execution != Execution::whole) {
    throw std::logic_error("pipeline: next() needs .execution = Execution::whole; or use run()");
  }
  complete_package();
  const Next next = run_->loop().next(package_, patience, poll);
  has_package_ = next == Next::package;
  if (next == Next::ended) run_->finish();
  if (has_package_) package = package_;
  return next;
}

void Pipeline::complete() {
  const Working working(*this);
  complete_package();
}

void Pipeline::complete_package() {
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
  complete_package();
  try {
    run_->loop().run(consumer, poll);
  } catch (...) {
    stop(false);
    run_->finish();
    throw;
  }
  run_->finish();
}

void Pipeline::flush() {
  const std::lock_guard lock(control_);
  run_->loop().flush();
}

void Pipeline::stop(bool drain) {
  const std::lock_guard lock(control_);
  run_->leave();
  if (door_.shut()) run_->close();  // else the push that is inside does
  if (!drain) run_->loop().abandon();
}

void Pipeline::start() {
  if (!algorithm_) return begin();
  if (door_.is_open()) return;
  require_another_thread();
  const std::lock_guard lock(worker_control_);
  if (door_.is_open()) return;  // another thread has been faster
  end_work();
  begin();
  set_to_work();
}

void Pipeline::begin() {
  const Working working(*this);  // nobody else opens meanwhile
  if (door_.is_open()) return;
  door_.wait_until_empty();
  const std::lock_guard lock(control_);
  if (has_package_) throw std::logic_error("pipeline: a package is in work; complete() it first");
  if (scheme_.latency_bound_ns() != 0) scheme_.set_latency_bound_ns(latency_bound_ns_);
  run_ = std::make_unique<LiveRun>(scheme_, config_);  // or the run before stays, if this throws
  upstream_marks_ = 0;
  upstream_packets_ = 0;
  door_.open();
}

void Pipeline::set_latency(double latency_us) {
  const std::int64_t bound_ns = checked_latency_bound_ns(latency_us);
  const std::lock_guard lock(control_);
  latency_bound_ns_ = bound_ns;
  config_.latency_us = latency_us;
  run_->set_latency_bound(bound_ns);
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
          .open = door_.is_open(),
          .stalled = run_->stalled(),
          .most_waiting = run_->most_waiting(),
          .latency_bound_ns = latency_bound_ns_,
          .sensor_delay_ns = run_->sensor_delay().last_ns(),
          .sensor_delay_max_ns = run_->sensor_delay().max_ns()};
}

}  // namespace asap
