#include "asap/runner/pipeline.hpp"

#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <utility>

#include "asap/core/check.hpp"
#include "asap/schemes/deadline.hpp"
#include "core/made.hpp"
#include "runner/live_run.hpp"
#include "runner/prefault.hpp"
#include "runner/push_door.hpp"

namespace asap {
namespace {

thread_local const void* worker_of = nullptr;  // whose worker this thread is

}  // namespace

class Pipeline::Impl {
 public:
  Impl(std::unique_ptr<Scheme> own_scheme, Scheme& scheme, RunConfig config, Consumer algorithm);
  ~Impl();
  static std::unique_ptr<Impl> with_worker(RunConfig config, Consumer algorithm);
  static PipelineMemory memory(const RunConfig& config) noexcept;

  template <class Push>
  bool push_by(const Push& push);
  void upstream_lost(std::uint64_t marks, std::uint64_t packets) noexcept;
  Next next(Package& package, std::chrono::nanoseconds patience, const Poll& poll);
  void complete();
  void abandon();
  void run(const Consumer& consumer, const Poll& poll);
  void join();
  void flush();
  void stop(bool drain);
  void start();
  void set_latency(std::chrono::nanoseconds latency);
  bool is_open() const noexcept { return door_.is_open(); }
  Ledger ledger() const;
  PipelineStats stats() const;
  const Telemetry& telemetry() const noexcept { return run_->telemetry(); }

 private:
  class Inside;

  void set_to_work();
  void complete_package();
  void begin();
  void require_another_thread() const;
  void end_work();

  const std::unique_ptr<Scheme> own_scheme_;
  Scheme& scheme_;
  RunConfig config_;
  std::int64_t latency_bound_ns_;
  mutable std::mutex control_;  // start, stop, flush and the snapshots; never push or next
  std::unique_ptr<LiveRun> run_;
  PushDoor door_;
  std::atomic<std::uint64_t> upstream_marks_{0};
  std::atomic<std::uint64_t> upstream_packets_{0};

  std::atomic<bool> consuming_{false};  // a consumer is inside
  Package package_;                     // in work, if has_package_
  bool has_package_ = false;

  const Consumer algorithm_;   // of the worker
  std::mutex worker_control_;  // start and join; taken before control_
  std::exception_ptr error_;   // what it has thrown
  std::atomic<bool> works_{false};
  std::atomic<bool> has_stack_{false};  // the worker: of RunConfig::prefault
  std::thread worker_;
};

// The consumer's side has one guest at a time.
class Pipeline::Impl::Inside {
 public:
  explicit Inside(Impl& pipeline) : pipeline_(pipeline) {
    if (pipeline_.consuming_.exchange(true, std::memory_order_acq_rel)) {
      throw std::logic_error("pipeline: another thread consumes; stop() it first");
    }
  }
  ~Inside() { pipeline_.consuming_.store(false, std::memory_order_release); }
  Inside(const Inside&) = delete;
  Inside& operator=(const Inside&) = delete;

 private:
  Impl& pipeline_;
};

Pipeline::Impl::Impl(std::unique_ptr<Scheme> own_scheme, Scheme& scheme, RunConfig config,
                     Consumer algorithm)
    : own_scheme_(std::move(own_scheme)),
      scheme_(scheme),
      config_(std::move(config)),
      latency_bound_ns_(asap::latency_bound_ns(config_, scheme_)),
      run_(std::make_unique<LiveRun>(scheme_, config_)),
      algorithm_(std::move(algorithm)) {
  door_.open();
}

std::unique_ptr<Pipeline::Impl> Pipeline::Impl::with_worker(RunConfig config, Consumer algorithm) {
  if (!algorithm) throw_bad_value("algorithm", "none", "give what the events are for");
  auto scheme = std::make_unique<Deadline>(
      DeadlineConfig{.latency = config.latency.value_or(kDefaultLatency)});
  Scheme& own = *scheme;
  auto work =
      std::make_unique<Impl>(std::move(scheme), own, std::move(config), std::move(algorithm));
  work->set_to_work();
  return work;
}

PipelineMemory Pipeline::Impl::memory(const RunConfig& config) noexcept {
  constexpr std::size_t kThread = 2 * sizeof(void*);  // what std::thread keeps of its function
  PipelineMemory memory = Run::memory(config, config.latency.value_or(kDefaultLatency).count());
  memory.rest += sizeof(Impl) + sizeof(LiveRun) + sizeof(Deadline) + kThread;
  return memory;
}

Pipeline::Impl::~Impl() {
  stop(false);
  door_.wait_until_empty();
  if (worker_.joinable()) worker_.join();
}

void Pipeline::Impl::set_to_work() {
  const auto give_up = [this] {
    works_ = false;
    works_.notify_all();
    abandon();
  };
  works_ = true;
  has_stack_ = false;
  try {
    worker_ = std::thread([this] {
      worker_of = this;
      if (config_.prefault) touch_stack();
      has_stack_ = true;
      has_stack_.notify_all();
      try {
        run(algorithm_, {});
      } catch (...) {
        error_ = std::current_exception();
      }
      works_ = false;
      works_.notify_all();
    });
    if (config_.prefault) has_stack_.wait(false);
  } catch (const std::system_error& error) {
    give_up();
    throw std::system_error(error.code(),
                            "the worker has no thread; end another one, or use run() on your own");
  } catch (...) {
    give_up();
    throw;
  }
}

void Pipeline::Impl::join() {
  require_another_thread();
  works_.wait(true);
  const std::lock_guard lock(worker_control_);
  if (!works_) end_work();  // else a new run has begun
}

void Pipeline::Impl::require_another_thread() const {
  if (worker_of != this) return;
  throw std::logic_error("pipeline: the worker cannot wait for itself; stop() is enough");
}

void Pipeline::Impl::end_work() {
  if (!worker_.joinable()) return;
  worker_.join();
  if (error_) std::rethrow_exception(std::exchange(error_, {}));
}

template <class Push>
bool Pipeline::Impl::push_by(const Push& push) {
  if (!door_.enter()) return false;
  struct Leave {
    Impl& pipeline;
    ~Leave() {
      pipeline.door_.leave([this] { pipeline.run_->close(); });
    }
  } leave{*this};
  push(*run_);
  return true;
}

void Pipeline::Impl::upstream_lost(std::uint64_t marks, std::uint64_t packets) noexcept {
  upstream_marks_.fetch_add(marks, std::memory_order_relaxed);
  upstream_packets_.fetch_add(packets, std::memory_order_relaxed);
}

Pipeline::Next Pipeline::Impl::next(Package& package, std::chrono::nanoseconds patience,
                                    const Poll& poll) {
  const Inside inside(*this);
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

void Pipeline::Impl::complete() {
  const Inside inside(*this);
  complete_package();
}

void Pipeline::Impl::complete_package() {
  if (has_package_) run_->loop().complete(package_);
  has_package_ = false;
}

void Pipeline::Impl::abandon() {
  stop(false);
  if (consuming_.exchange(true, std::memory_order_acq_rel)) return;  // it will see the end itself
  has_package_ = false;
  run_->finish();
  consuming_.store(false, std::memory_order_release);
}

void Pipeline::Impl::run(const Consumer& consumer, const Poll& poll) {
  const Inside inside(*this);
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

void Pipeline::Impl::flush() {
  const std::lock_guard lock(control_);
  run_->loop().flush();
}

void Pipeline::Impl::stop(bool drain) {
  const std::lock_guard lock(control_);
  run_->leave();
  if (door_.shut()) run_->close();  // else the push that is inside does
  if (!drain) run_->loop().abandon();
}

void Pipeline::Impl::start() {
  if (!algorithm_) return begin();
  if (door_.is_open()) return;
  require_another_thread();
  const std::lock_guard lock(worker_control_);
  if (door_.is_open()) return;  // another thread has been faster
  end_work();
  begin();
  set_to_work();
}

void Pipeline::Impl::begin() {
  const Inside inside(*this);  // no other thread opens meanwhile
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

void Pipeline::Impl::set_latency(std::chrono::nanoseconds latency) {
  const std::int64_t bound_ns = checked_latency_ns(latency);
  const std::lock_guard lock(control_);
  latency_bound_ns_ = bound_ns;
  config_.latency = latency;
  run_->set_latency_bound(bound_ns);
}

Ledger Pipeline::Impl::ledger() const {
  const std::lock_guard lock(control_);
  return run_->ledger();
}

PipelineStats Pipeline::Impl::stats() const {
  const std::lock_guard lock(control_);
  const Telemetry& telemetry = run_->telemetry();
  return {.ledger = run_->ledger(),
          .rejected = run_->rejected(),
          .latency = telemetry.latency,
          .packages = telemetry.log.totals(),
          .gap_us = run_->gap_us(),
          .elapsed_ns = run_->elapsed_ns(),
          .clock_resets = run_->clock_resets(),
          .upstream_marks = upstream_marks_.load(std::memory_order_relaxed),
          .upstream_packets = upstream_packets_.load(std::memory_order_relaxed),
          .open = door_.is_open(),
          .stalled = run_->stalled(),
          .max_waiting = run_->max_waiting(),
          .latency_bound_ns = latency_bound_ns_,
          .sensor_delay_ns = run_->sensor_delay().last_ns(),
          .sensor_delay_max_ns = run_->sensor_delay().max_ns()};
}

Pipeline::Pipeline(Scheme& scheme, RunConfig config)
    : impl_(std::make_unique<Impl>(nullptr, scheme, std::move(config), Consumer{})) {}

Pipeline::Pipeline(RunConfig config, Consumer algorithm)
    : impl_(Impl::with_worker(std::move(config), std::move(algorithm))) {}

Pipeline::~Pipeline() = default;

PipelineMemory Pipeline::memory(const RunConfig& config) noexcept { return Impl::memory(config); }
std::size_t memory_bytes(const RunConfig& config) noexcept {
  return Pipeline::memory(config).total();
}

bool Pipeline::push(EventSpan events, Arrival arrival) {
  return impl_->push_by([&](LiveRun& run) { run.push(events, arrival); });
}
bool Pipeline::push(EventSpan events, Arrival arrival, const Poll& poll) {
  return impl_->push_by([&](LiveRun& run) { run.push(events, arrival, poll); });
}
void Pipeline::upstream_lost(std::uint64_t marks, std::uint64_t packets) noexcept {
  impl_->upstream_lost(marks, packets);
}
Pipeline::Next Pipeline::next(Package& package, std::chrono::nanoseconds patience,
                              const Poll& poll) {
  return impl_->next(package, patience, poll);
}
void Pipeline::complete() { impl_->complete(); }
void Pipeline::abandon() { impl_->abandon(); }
void Pipeline::run(const Consumer& consumer, const Poll& poll) { impl_->run(consumer, poll); }
void Pipeline::join() { impl_->join(); }
void Pipeline::flush() { impl_->flush(); }
void Pipeline::stop(bool drain) { impl_->stop(drain); }
void Pipeline::start() { impl_->start(); }
void Pipeline::set_latency(std::chrono::nanoseconds latency) { impl_->set_latency(latency); }
bool Pipeline::is_open() const noexcept { return impl_->is_open(); }
Ledger Pipeline::ledger() const { return impl_->ledger(); }
PipelineStats Pipeline::stats() const { return impl_->stats(); }
const Telemetry& Pipeline::telemetry() const noexcept { return impl_->telemetry(); }

Result<Pipeline> make_pipeline(Scheme& scheme, RunConfig config) noexcept {
  return made<Pipeline>([&] { return std::make_unique<Pipeline>(scheme, std::move(config)); });
}

Result<Pipeline> make_pipeline(RunConfig config, Consumer algorithm) noexcept {
  return made<Pipeline>(
      [&] { return std::make_unique<Pipeline>(std::move(config), std::move(algorithm)); });
}

}  // namespace asap
