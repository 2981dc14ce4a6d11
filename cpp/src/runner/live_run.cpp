#include "runner/live_run.hpp"

#include <algorithm>
#include <exception>

namespace asap {
namespace {

constexpr std::uint64_t kIntakeSeed = 0x696e74616b65;  // not the gamma filter's numbers

}  // namespace

LiveRun::LiveRun(Scheme& scheme, const RunConfig& config)
    : run_(scheme, config, Run::Source::camera),
      intake_(run_.buffer(), run_.arrivals(), doorbell_, config.when_full,
              config.seed ^ kIntakeSeed),
      loop_(run_.buffer(), run_.packager(), run_.telemetry(), doorbell_, clock_, intake_.room()) {}

// take(EventSpan) brings good events into the ring.
template <class Take>
void LiveRun::push_by(const Take& take, EventSpan events,
                      std::optional<Steady::time_point> arrival) {
  struct Publish {
    Run& run;
    ~Publish() { run.publish(); }
  } publish{run_};  // also when the validator refuses an event
  bool timed = false;
  run_.validator().check(events, [&](EventSpan good) {
    if (!timed) {
      const Steady::time_point now = System::now();
      const Steady::time_point came = std::clamp(arrival.value_or(now), Steady::time_point{}, now);
      if (!begun_) begin(good.front(), came);
      arrival_ns_ = std::max(arrival_ns_, clock_.at(came));
      timed = true;
    }
    heed_clock();
    take(good);
    sensor_delay_.note(good.back().t, arrival_ns_);
  });
}

void LiveRun::push(EventSpan events, std::optional<Steady::time_point> arrival) {
  push_by([this](EventSpan good) { intake_.take(good, arrival_ns_); }, events, arrival);
}

void LiveRun::push(EventSpan events, std::optional<Steady::time_point> arrival,
                   const Intake::Poll& poll) {
  std::exception_ptr interrupted;  // by the poll: what follows counts too, but waits no longer
  const auto take = [&](EventSpan good) {
    try {
      if (interrupted) {
        intake_.put(good, arrival_ns_);
      } else {
        intake_.take(good, arrival_ns_, poll);
      }
    } catch (...) {
      interrupted = std::current_exception();
    }
  };
  push_by(take, events, arrival);
  if (interrupted) std::rethrow_exception(interrupted);
}

void LiveRun::begin(const Event& first, Steady::time_point arrival) noexcept {
  run_.begin(first.t);
  first_arrival_ns_ = run_.axis().to_ns(first.t);
  clock_.start(first_arrival_ns_, arrival);
  arrival_ns_ = first_arrival_ns_;
  loop_.begin();
  begun_ = true;
}

// A sensor that begins anew: what came before shall not wait for what comes now.
void LiveRun::heed_clock() noexcept {
  const std::uint64_t resets = run_.validator().clock_resets();
  if (resets == clock_resets_) return;
  clock_resets_ = resets;
  sensor_delay_.forget();
  loop_.flush();
}

void LiveRun::set_latency_bound(std::int64_t bound_ns) noexcept {
  run_.arrivals().set_step(Run::arrival_step_ns(bound_ns));
  loop_.set_latency_bound(bound_ns);
}

void LiveRun::close() noexcept {
  closed_ns_ = begun_ ? clock_.now_ns() : first_arrival_ns_;
  run_.buffer().close();
  doorbell_.wake();
}

Ledger LiveRun::ledger() const noexcept {
  const bool is_over = finished_.load(std::memory_order_acquire) && run_.buffer().closed();
  return run_.ledger(is_over, intake_.discarded());
}

std::int64_t LiveRun::elapsed_ns() const noexcept {
  if (run_.buffer().closed()) return closed_ns_ - first_arrival_ns_;
  return run_.buffer().tail() == 0 ? 0 : clock_.now_ns() - first_arrival_ns_;
}

}  // namespace asap
