#include "asap/runner/pipeline.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <utility>

#include "asap/schemes/deadline.hpp"
#include "core/check.hpp"
#include "core/made.hpp"
#include "runner/clock.hpp"
#include "runner/consumer_loop.hpp"
#include "runner/doorbell.hpp"
#include "runner/intake.hpp"
#include "runner/prefault.hpp"
#include "runner/process.hpp"
#include "runner/push_door.hpp"
#include "runner/run.hpp"
#include "runner/sensor_delay.hpp"
#include "schemes/scheme_hold.hpp"

namespace asap::inline v0_1 {
namespace {

thread_local const void* worker_of = nullptr;  // whose worker this thread is

constexpr std::chrono::nanoseconds kLongestWait = std::chrono::hours(24);  // no clock overflows

constexpr auto kLook = std::chrono::microseconds(100);  // how often ~Pipeline looks at the seat

constexpr std::uint64_t kIntakeSeed = 0x696e74616b65;  // not the gamma filter's numbers

}  // namespace

// From the first event to the end. An event's time is its arrival on the steady clock; a wall clock
// that steps has no effect. Takes no memory: that is Run's.
struct LiveRun {
  // The run is new.
  LiveRun(Run& its_run, const RunConfig& config) noexcept;

  // Producer. take(EventSpan) brings good events into the ring. A timestamp that shows that the
  // sensor's clock was set back makes what waits due.
  template <class Take>
  void push(const Take& take, EventSpan events, Pipeline::Arrival arrival);
  void begin(const Event& first, std::chrono::steady_clock::time_point arrival) noexcept;
  void heed_clock() noexcept;

  // Once the producer has gone: nothing follows.
  void close() noexcept;

  // Any thread. Snapshots, see Run::ledger; exact after close() and `finished`.
  bool is_over() const noexcept;
  Run::Outside outside() const noexcept { return {is_over(), intake.discarded()}; }
  // Any thread. The first arrival; the time since, until close().
  RunClock::Steady::time_point begun_at() const noexcept;
  std::int64_t elapsed_ns() const noexcept;

  Run& run;
  Doorbell doorbell;
  Intake intake;
  RunClock clock;
  ConsumerLoop loop;

  std::atomic<bool> finished{false};  // no package will be taken or booked any more
  bool begun = false;                 // the producer's, like the next two
  std::int64_t arrival_ns = 0;        // of the newest push
  std::int64_t first_arrival_ns = 0;
  std::int64_t closed_ns = 0;
  std::uint64_t clock_resets = 0;  // the producer's
  SensorDelay sensor_delay;
};

struct Pipeline::Impl {
  enum class Seat { free, taken, being_cleared };
  class Inside;

  Impl(std::unique_ptr<Scheme> own_scheme, Scheme& its_scheme, RunConfig run_config,
       Consumer its_algorithm);
  ~Impl();

  template <class Push>
  bool enter(const Push& push);
  void complete_package();
  void stop(bool drain);
  void stop_live(bool drain);
  void abandon();
  void consume(const Consumer& consumer, const Poll& poll);
  void begin();
  void set_to_work();
  void require_another_thread() const;
  // This process has forked, and the worker stayed with its parent.
  bool is_elsewhere() const noexcept {
    return workers_process != 0 && workers_process != this_process();
  }
  void require_no_worker() const;
  void take_scheme();
  void finish() noexcept;
  void fail();
  void say_ended() noexcept;
  void start_on_worker();
  void end_work();

  const std::unique_ptr<Scheme> own_scheme;
  Scheme& scheme;
  SchemeHold hold;  // the consumer's, from its first call to the end of the run
  RunConfig config;
  std::int64_t latency_bound_ns;
  mutable std::mutex control;  // start, stop, flush and the snapshots; never push or next
  Run memory;
  std::optional<LiveRun> live;
  std::uint64_t runs = 1;
  PushDoor door;
  std::atomic<std::uint64_t> upstream_marks{0};
  std::atomic<std::uint64_t> upstream_packets{0};

  std::atomic<Seat> seat{Seat::free};  // the consumer's
  Package package;                     // in work, if has_package
  bool has_package = false;

  const Consumer algorithm;   // of the worker
  std::mutex worker_control;  // start and join; taken before control
  std::exception_ptr error;   // what it has thrown
  std::atomic<bool> works{false};
  std::mutex end;  // of the worker's work
  std::condition_variable ended;
  std::atomic<bool> has_stack{false};  // the worker: of RunConfig::prefault
  std::thread worker;
  std::atomic<std::int64_t> workers_process{0};  // 0: no worker
};

// The consumer's side has one guest at a time.
class Pipeline::Impl::Inside {
 public:
  explicit Inside(Impl& pipeline) : pipeline_(pipeline) {
    Seat found = Seat::free;
    while (!pipeline_.seat.compare_exchange_weak(found, Seat::taken, std::memory_order_acq_rel)) {
      if (found == Seat::taken) {
        throw std::logic_error("pipeline: another thread consumes; stop() it first");
      }
      if (found == Seat::being_cleared) std::this_thread::yield();  // by abandon()
      found = Seat::free;
    }
  }
  ~Inside() { pipeline_.seat.store(Seat::free, std::memory_order_release); }
  Inside(const Inside&) = delete;
  Inside& operator=(const Inside&) = delete;

 private:
  Impl& pipeline_;
};

// ---- a run

LiveRun::LiveRun(Run& its_run, const RunConfig& config) noexcept
    : run(its_run),
      intake(run.buffer(), run.arrivals(), doorbell, config.when_full, config.seed ^ kIntakeSeed),
      loop(run.buffer(), run.packager(), run.telemetry(), doorbell, clock, intake.room()) {
  run.validator().doubt_resets();
}

template <class Take>
void LiveRun::push(const Take& take, EventSpan events, Pipeline::Arrival arrival) {
  struct Publish {
    LiveRun& live;
    ~Publish() {
      live.intake.announce();
      live.run.publish();
    }
  } publish{*this};  // also when the validator refuses an event
  bool timed = false;
  run.validator().check(events, [&](EventSpan good) {
    if (!timed) {
      const auto now = System::now();
      const auto came = std::clamp(arrival.value_or(now), RunClock::Steady::time_point{}, now);
      if (!begun) begin(good.front(), came);
      arrival_ns = std::max(arrival_ns, clock.at(came));
      timed = true;
    }
    heed_clock();
    take(good);
    sensor_delay.note(good.back().t, arrival_ns);
  });
}

void LiveRun::begin(const Event& first, std::chrono::steady_clock::time_point arrival) noexcept {
  run.begin(first.t);
  first_arrival_ns = run.axis().to_ns(first.t);
  clock.start(first_arrival_ns, arrival);
  arrival_ns = first_arrival_ns;
  loop.begin();
  begun = true;
}

// A sensor that begins anew: what came before shall not wait for what comes now.
void LiveRun::heed_clock() noexcept {
  const std::uint64_t resets = run.validator().clock_resets();
  if (resets == clock_resets) return;
  clock_resets = resets;
  sensor_delay.forget();
  loop.flush();
}

void LiveRun::close() noexcept {
  closed_ns = begun ? clock.now_ns() : first_arrival_ns;
  run.buffer().close();
  doorbell.wake();
}

bool LiveRun::is_over() const noexcept {
  return finished.load(std::memory_order_acquire) && run.buffer().closed();
}

RunClock::Steady::time_point LiveRun::begun_at() const noexcept {
  if (run.buffer().tail() == 0) return {};
  return clock.when(first_arrival_ns);
}

std::int64_t LiveRun::elapsed_ns() const noexcept {
  if (run.buffer().closed()) return closed_ns - first_arrival_ns;
  return run.buffer().tail() == 0 ? 0 : clock.now_ns() - first_arrival_ns;
}

// ---- construction

Pipeline::Impl::Impl(std::unique_ptr<Scheme> made_scheme, Scheme& its_scheme, RunConfig run_config,
                     Consumer its_algorithm)
    : own_scheme(std::move(made_scheme)),
      scheme(its_scheme),
      hold(scheme),
      config(std::move(run_config)),
      latency_bound_ns(asap::latency_bound_ns(config, scheme)),
      memory(scheme, config, Run::Source::camera),
      live(std::in_place, memory, config),
      algorithm(std::move(its_algorithm)) {
  if (!algorithm) hold.release();
  door.open();
}

Pipeline::Impl::~Impl() {
  stop(false);
  if (is_elsewhere()) {
    worker.detach();
    return;
  }
  door.wait_until_empty();
  if (worker.joinable()) worker.join();
  while (seat.load(std::memory_order_acquire) != Seat::free) std::this_thread::sleep_for(kLook);
}

Pipeline::Pipeline(Scheme& scheme, RunConfig config)
    : impl_(std::make_unique<Impl>(nullptr, scheme, std::move(config), Consumer{})) {}

Pipeline::Pipeline(Scheme& scheme, RunConfig config, Consumer algorithm)
    : impl_(
          std::make_unique<Impl>(nullptr, scheme, std::move(config), given(std::move(algorithm)))) {
  impl_->set_to_work();
}

Pipeline::Pipeline(RunConfig config, Consumer algorithm)
    : impl_([&] {
        auto scheme = std::make_unique<Deadline>(
            DeadlineConfig{.latency = config.latency.value_or(kDefaultLatency)});
        Scheme& own = *scheme;
        return std::make_unique<Impl>(std::move(scheme), own, std::move(config),
                                      given(std::move(algorithm)));
      }()) {
  impl_->set_to_work();
}

Pipeline::~Pipeline() = default;

PipelineMemory Pipeline::memory(const RunConfig& config) noexcept {
  constexpr std::size_t kThread = 2 * sizeof(void*);  // what std::thread keeps of its function
  PipelineMemory memory = Run::memory(config, config.latency.value_or(kDefaultLatency).count());
  memory.rest += sizeof(Impl) + sizeof(Deadline) + Deadline::memory_bytes() + kThread;
  return memory;
}

std::size_t memory_bytes(const RunConfig& config) noexcept {
  return Pipeline::memory(config).total();
}

// ---- producer

template <class Push>
bool Pipeline::Impl::enter(const Push& push) {
  if (!door.enter()) return false;
  struct Leave {
    Impl& pipeline;
    ~Leave() {
      pipeline.door.leave([this] { pipeline.live->close(); });
    }
  } leave{*this};
  push(*live);
  return true;
}

bool Pipeline::push(EventSpan events, Arrival arrival) {
  return impl_->enter([&](LiveRun& live) {
    live.push([&](EventSpan good) { live.intake.take(good, live.arrival_ns); }, events, arrival);
  });
}

bool Pipeline::push(EventSpan events, Arrival arrival, const Poll& poll) {
  return impl_->enter([&](LiveRun& live) {
    std::exception_ptr interrupted;  // by the poll: what follows counts too, but waits no longer
    const auto take = [&](EventSpan good) {
      try {
        if (interrupted) {
          live.intake.put(good, live.arrival_ns);
        } else {
          live.intake.take(good, live.arrival_ns, poll);
        }
      } catch (...) {
        interrupted = std::current_exception();
      }
    };
    live.push(take, events, arrival);
    if (interrupted) std::rethrow_exception(interrupted);
  });
}

void Pipeline::begin_epoch(std::int64_t first_us) noexcept {
  impl_->enter([&](LiveRun& live) {
    live.run.validator().begin_epoch(first_us);
    live.run.publish();
  });
}

std::int64_t Pipeline::clock_offset_us() const noexcept { return impl_->memory.clock_offset_us(); }

void Pipeline::upstream_lost(std::uint64_t marks, std::uint64_t packets) noexcept {
  impl_->upstream_marks.fetch_add(marks, std::memory_order_relaxed);
  impl_->upstream_packets.fetch_add(packets, std::memory_order_relaxed);
}

// ---- consumer

Next Pipeline::next(Package& package, std::chrono::nanoseconds patience, const Poll& poll) {
  impl_->require_no_worker();
  const Impl::Inside inside(*impl_);
  if (impl_->config.execution != Execution::whole) {
    throw std::logic_error("pipeline: next() needs .execution = Execution::whole; or use run()");
  }
  impl_->take_scheme();
  impl_->complete_package();
  const Next next = impl_->live->loop.next(impl_->package, patience, poll);
  impl_->has_package = next == Next::package;
  if (next == Next::ended) impl_->finish();
  if (impl_->has_package) package = impl_->package;
  return next;
}

void Pipeline::complete() {
  impl_->require_no_worker();
  const Impl::Inside inside(*impl_);
  impl_->complete_package();
}

void Pipeline::Impl::take_scheme() {
  if (!live->finished.load(std::memory_order_relaxed)) hold.take();
}

// The consumer's side is over: its seat is held.
void Pipeline::Impl::finish() noexcept {
  live->finished.store(true, std::memory_order_release);
  hold.release();
}

void Pipeline::Impl::fail() {
  live->run.fail();
  stop(false);
  finish();
}

void Pipeline::Impl::complete_package() {
  if (has_package) live->loop.complete(package);
  has_package = false;
}

void Pipeline::abandon() { impl_->abandon(); }

void Pipeline::Impl::abandon() {
  const std::lock_guard lock(control);  // to the end: no new run begins meanwhile
  stop_live(false);
  if (works) return;  // the worker sees the end itself
  Seat found = Seat::free;
  if (!seat.compare_exchange_strong(found, Seat::being_cleared, std::memory_order_acq_rel)) return;
  has_package = false;
  finish();
  seat.store(Seat::free, std::memory_order_release);
}

void Pipeline::run(const Consumer& consumer, const Poll& poll) {
  impl_->require_no_worker();
  impl_->consume(given(consumer), poll);
}

void Pipeline::Impl::consume(const Consumer& consumer, const Poll& poll) {
  const Inside inside(*this);
  take_scheme();
  complete_package();
  try {
    live->loop.run(consumer, poll);
  } catch (...) {
    fail();
    throw;
  }
  finish();
}

// ---- the worker

void Pipeline::Impl::set_to_work() {
  const auto give_up = [this] {
    say_ended();
    abandon();
  };
  works = true;
  workers_process = this_process();
  has_stack = false;
  try {
    worker = std::thread([this] {
      worker_of = this;
      if (config.prefault) touch_stack();
      has_stack = true;
      has_stack.notify_all();
      try {
        start_on_worker();
        consume(algorithm, {});
      } catch (...) {
        error = std::current_exception();
      }
      say_ended();
    });
    if (config.prefault) has_stack.wait(false);
  } catch (const std::system_error& refused) {
    give_up();
    throw std::system_error(refused.code(),
                            "the worker has no thread; end another one, or use run() on your own");
  } catch (...) {
    give_up();
    throw;
  }
}

void Pipeline::Impl::say_ended() noexcept {
  const std::lock_guard lock(end);
  works = false;
  ended.notify_all();
}

void Pipeline::Impl::start_on_worker() {
  if (!config.on_worker_start) return;
  try {
    config.on_worker_start();
  } catch (...) {
    fail();
    throw;
  }
}

void Pipeline::join() {
  while (!join_for(std::chrono::hours(1))) {
  }
}

bool Pipeline::join_for(std::chrono::nanoseconds timeout) {
  impl_->require_another_thread();
  {
    std::unique_lock lock(impl_->end);
    const auto is_over = [this] { return !impl_->works; };
    if (!impl_->ended.wait_for(lock, std::min(timeout, kLongestWait), is_over)) return false;
  }
  const std::lock_guard lock(impl_->worker_control);
  if (!impl_->works) impl_->end_work();  // else a new run has begun
  return true;
}

void Pipeline::Impl::require_another_thread() const {
  if (worker_of == this) {
    throw std::logic_error("pipeline: the worker cannot wait for itself; stop() is enough");
  }
  if (is_elsewhere()) {
    throw std::logic_error(
        "pipeline: the worker stayed with the process that forked; make one here");
  }
}

// The seat is the worker's from the constructor on, also between two runs.
void Pipeline::Impl::require_no_worker() const {
  if (!algorithm) return;
  throw std::logic_error("pipeline: its worker consumes; for run() and next() make one without");
}

void Pipeline::Impl::end_work() {
  if (!worker.joinable()) return;
  worker.join();
  if (error) std::rethrow_exception(std::exchange(error, {}));
}

// ---- any thread

void Pipeline::flush() {
  const std::lock_guard lock(impl_->control);
  impl_->live->loop.flush();
}

void Pipeline::stop(bool drain) { impl_->stop(drain); }

void Pipeline::Impl::stop(bool drain) {
  const std::lock_guard lock(control);
  stop_live(drain);
}

// Precondition: control is locked.
void Pipeline::Impl::stop_live(bool drain) {
  live->intake.leave();
  if (door.shut()) live->close();  // else the push that is inside does
  if (!drain) live->loop.abandon();
}

void Pipeline::start() {
  if (!impl_->algorithm) return impl_->begin();
  if (impl_->door.is_open()) return;
  impl_->require_another_thread();
  const std::lock_guard lock(impl_->worker_control);
  if (impl_->door.is_open()) return;  // another thread has been faster
  impl_->end_work();
  impl_->begin();
  impl_->set_to_work();
}

void Pipeline::Impl::begin() {
  const Inside inside(*this);  // no other thread opens meanwhile
  if (door.is_open()) return;
  door.wait_until_empty();
  const std::lock_guard lock(control);
  if (has_package) throw std::logic_error("pipeline: a package is in work; complete() it first");
  hold.take();
  struct Free {
    Impl& pipeline;
    bool is_done = false;
    ~Free() {
      if (!is_done || !pipeline.algorithm) pipeline.hold.release();
    }
  } free{*this};
  if (scheme.latency_bound_ns() != 0) scheme.set_latency_bound_ns(latency_bound_ns);
  memory.reset(scheme, config);  // or the run before stays, if this throws
  live.emplace(memory, config);
  free.is_done = true;
  ++runs;
  upstream_marks = 0;
  upstream_packets = 0;
  door.open();
}

void Pipeline::set_latency(std::chrono::nanoseconds latency) {
  const std::int64_t bound_ns = checked_latency_ns(latency);
  const std::lock_guard lock(impl_->control);
  impl_->latency_bound_ns = bound_ns;
  impl_->config.latency = latency;
  impl_->live->run.arrivals().set_step(Run::arrival_step_ns(bound_ns));
  impl_->live->loop.set_latency_bound(bound_ns);
}

bool Pipeline::is_open() const noexcept { return impl_->door.is_open(); }

Ledger Pipeline::ledger() const {
  const std::lock_guard lock(impl_->control);
  return impl_->memory.ledger(impl_->live->outside());
}

PipelineStats Pipeline::stats() const {
  PipelineStats stats;
  this->stats(stats);
  return stats;
}

void Pipeline::stats(PipelineStats& stats) const {
  const std::lock_guard lock(impl_->control);
  const LiveRun& live = *impl_->live;
  live.run.copy_stats_to(stats, live.outside());
  stats.gap_us = live.run.gap_us(&live.intake.gap());
  stats.run = impl_->runs;
  stats.begun = live.begun_at();
  stats.elapsed_ns = live.elapsed_ns();
  stats.upstream_marks = impl_->upstream_marks.load(std::memory_order_relaxed);
  stats.upstream_packets = impl_->upstream_packets.load(std::memory_order_relaxed);
  stats.open = is_open();
  stats.stalled = live.loop.stalled(live.run.buffer().size());
  stats.max_waiting = live.intake.max_waiting();
  stats.latency_bound_ns = impl_->latency_bound_ns;
  stats.sensor_delay_ns = live.sensor_delay.last_ns();
  stats.sensor_delay_max_ns = live.sensor_delay.max_ns();
}

const RunLog& Pipeline::log() const noexcept { return impl_->memory.telemetry().log; }

// ---- without exceptions

Result<Pipeline> make_pipeline(Scheme& scheme, RunConfig config) noexcept {
  return made<Pipeline>([&] { return std::make_unique<Pipeline>(scheme, std::move(config)); });
}

Result<Pipeline> make_pipeline(RunConfig config, Consumer algorithm) noexcept {
  return made<Pipeline>(
      [&] { return std::make_unique<Pipeline>(std::move(config), std::move(algorithm)); });
}

Result<Pipeline> make_pipeline(Scheme& scheme, RunConfig config, Consumer algorithm) noexcept {
  return made<Pipeline>(
      [&] { return std::make_unique<Pipeline>(scheme, std::move(config), std::move(algorithm)); });
}

}  // namespace asap::inline v0_1
