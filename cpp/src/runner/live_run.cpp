#include "asap/runner/live_run.hpp"

#include <algorithm>
#include <chrono>
#include <exception>

#include "asap/core/check.hpp"

namespace asap {
namespace {

// An event's age is right to this share of the bound.
constexpr std::int64_t kStepsPerBound = 1024;
constexpr std::uint64_t kIntakeSeed = 0x696e74616b65;  // not the gamma filter's numbers

std::int64_t arrival_step_ns(std::int64_t latency_bound_ns) {
  return std::max<std::int64_t>(latency_bound_ns / kStepsPerBound, 1);
}

PackagerConfig live_packager_config(const RunConfig& config) {
  require(!config.keep_mask, "keep_mask", 1, "not with live events; give it to a recording's run");
  PackagerConfig packager = packager_config(config);
  packager.drop_oldest = config.when_full == WhenFull::oldest;
  packager.most_copied = LiveRun::kMostCopied;
  return packager;
}

}  // namespace

LiveRun::LiveRun(Scheme& scheme, const RunConfig& config)
    : validator_(config.validator),
      telemetry_(latency_bound_ns(config, scheme), kLogRows),
      buffer_(ring_capacity(config, telemetry_.latency.bound_ns())),
      arrivals_(arrival_step_ns(telemetry_.latency.bound_ns())),
      packager_(buffer_, arrivals_, scheme, telemetry_, live_packager_config(config)),
      intake_(buffer_, arrivals_, doorbell_, config.when_full, config.seed ^ kIntakeSeed),
      loop_(buffer_, packager_, telemetry_, doorbell_, clock_, intake_.room()) {}

void LiveRun::push(EventSpan events, std::optional<Steady::time_point> arrival,
                   const Intake::Poll& poll) {
  struct Publish {
    LiveRun& run;
    ~Publish() { run.publish_counts(); }
  } publish{*this};  // also when the validator refuses an event
  bool timed = false;
  std::exception_ptr interrupted;  // by the poll: what follows counts too, but waits no longer
  validator_.check(events, [&](EventSpan good) {
    if (!timed) {
      const Steady::time_point now = System::now();
      const Steady::time_point came = std::clamp(arrival.value_or(now), Steady::time_point{}, now);
      if (!begun_) begin(good.front(), came);
      arrival_ns_ = std::max(arrival_ns_, clock_.at(came));
      timed = true;
    }
    heed_clock();
    try {
      if (interrupted) {
        intake_.put(good, arrival_ns_);
      } else {
        intake_.take(good, arrival_ns_, poll);
      }
    } catch (...) {
      interrupted = std::current_exception();
    }
    sensor_delay_.note(good.back().t, arrival_ns_);
  });
  if (interrupted) std::rethrow_exception(interrupted);
}

void LiveRun::begin(const Event& first, Steady::time_point arrival) noexcept {
  const TimeAxis axis(first.t, 1.0);
  packager_.set_axis(axis);
  first_arrival_ns_ = axis.to_ns(first.t);
  clock_.start(first_arrival_ns_, arrival);
  arrival_ns_ = first_arrival_ns_;
  loop_.begin();
  begun_ = true;
}

// A sensor that begins anew: what came before shall not wait for what comes now.
void LiveRun::heed_clock() noexcept {
  if (validator_.clock_resets() == clock_resets_) return;
  clock_resets_ = validator_.clock_resets();
  sensor_delay_.forget();
  loop_.flush();
}

void LiveRun::set_latency_bound(std::int64_t bound_ns) noexcept {
  arrivals_.set_step(arrival_step_ns(bound_ns));
  loop_.set_latency_bound(bound_ns);
}

void LiveRun::publish_counts() noexcept {
  const Rejections& counts = validator_.rejected();
  rejected_.nonmonotonic = counts.nonmonotonic;
  rejected_.out_of_bounds = counts.out_of_bounds;
  rejected_.bad_polarity = counts.bad_polarity;
  rejected_.bad_record = counts.bad_record;
  rejected_.before_start = counts.before_start;
}

void LiveRun::close() noexcept {
  closed_ns_ = begun_ ? clock_.now_ns() : first_arrival_ns_;
  buffer_.close();
  doorbell_.wake();
}

Rejections LiveRun::rejected() const noexcept {
  return {.nonmonotonic = rejected_.nonmonotonic,
          .out_of_bounds = rejected_.out_of_bounds,
          .bad_polarity = rejected_.bad_polarity,
          .bad_record = rejected_.bad_record,
          .before_start = rejected_.before_start};
}

Ledger LiveRun::ledger() const noexcept {
  // Then what the two sides own may be read.
  const bool over = finished_.load(std::memory_order_acquire) && buffer_.closed();
  Ledger ledger{.filtered = telemetry_.filtered,
                .discarded = telemetry_.discarded,
                .stale = telemetry_.stale,
                .overflow = telemetry_.overflow,
                .delivered = telemetry_.delivered};
  const std::uint64_t booked =
      ledger.filtered + ledger.discarded + ledger.stale + ledger.overflow + ledger.delivered;
  // What has been booked has been pushed, though a processor may see it before the tail.
  const std::uint64_t tail = std::max(buffer_.tail(), booked);
  ledger.pending = over ? buffer_.size() : tail - booked;
  const std::uint64_t thinned = intake_.discarded();
  const std::uint64_t overflow = buffer_.overflow();
  ledger.rejected = rejected().total();
  ledger.received = over ? validator_.received() : ledger.rejected + thinned + overflow + tail;
  ledger.discarded += thinned;
  ledger.overflow += overflow;
  return ledger;
}

std::int64_t LiveRun::elapsed_ns() const noexcept {
  if (buffer_.closed()) return closed_ns_ - first_arrival_ns_;
  return buffer_.tail() == 0 ? 0 : clock_.now_ns() - first_arrival_ns_;
}

}  // namespace asap
