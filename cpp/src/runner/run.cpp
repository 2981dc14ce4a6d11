#include "runner/run.hpp"

#include <algorithm>
#include <utility>

#include "core/check.hpp"
#include "packager/event_times.hpp"
#include "runner/prefault.hpp"
#include "runner/system.hpp"

namespace asap::inline v0_1 {
namespace {

constexpr std::int64_t kSlotsPerBound = 64;
constexpr std::int64_t kStepsPerBound = 1024;

const RunConfig& checked(const RunConfig& config) {
  require_known(config.execution, Execution::anytime, "execution");
  require_known(config.when_full, WhenFull::block, "when_full");
  return config;
}

std::unique_ptr<KeptMask> mask_for(const RunConfig& config, Run::Source source) {
  if (!config.keep_mask) return nullptr;
  require(source == Run::Source::recording, "keep_mask", 1,
          "not with live events; give it to a recording's run");
  return std::make_unique<KeptMask>();
}

std::size_t log_rows(const RunConfig& config, Run::Source source) {
  if (source == Run::Source::recording) return RunLog::kAllRows;
  require(config.log_rows <= RunLog::kMaxRows, "log_rows", config.log_rows,
          "must be at most 2^40; a live pipeline keeps the newest rows");
  return config.log_rows;
}

PackagerConfig packager_config(const RunConfig& config, Run::Source source, KeptMask* mask) {
  PackagerConfig packager{.seed = config.seed,
                          .execution = config.execution,
                          .flush = config.flush,
                          .front_filter = config.front_filter,
                          .kept_mask = mask,
                          .prefault = config.prefault};
  const bool is_live = source == Run::Source::camera;
  packager.drop_oldest = is_live && config.when_full == WhenFull::keep_newest;
  if (is_live) packager.max_copied = Run::kMaxCopied;
  if (config.max_copied > 0) packager.max_copied = config.max_copied;
  return packager;
}

}  // namespace

Run::Run(Scheme& scheme, const RunConfig& config, Source source)
    : mask_(mask_for(checked(config), source)),
      validator_(config.validator),
      telemetry_(asap::latency_bound_ns(config, scheme), log_rows(config, source)),
      buffer_(ring_capacity(config, latency_bound_ns())),
      ages_(source == Source::recording ? std::make_unique<AgeSlots>(std::max<std::int64_t>(
                                              latency_bound_ns() / kSlotsPerBound, 1))
                                        : nullptr),
      arrivals_(source == Source::camera
                    ? std::make_unique<ArrivalTimes>(arrival_step_ns(latency_bound_ns()),
                                                     ArrivalTimes::steps_for(buffer_.capacity()))
                    : nullptr),
      packager_(buffer_, ages_ ? EventTimes(*ages_) : EventTimes(*arrivals_), scheme, telemetry_,
                packager_config(config, source, mask_.get())) {
  if (mask_) mask_->follow(validator_);
  if (!config.prefault) return;
  buffer_.prefault();
  telemetry_.log.prefault();
  touch_code();
  System::now();  // its page, too
}

void Run::reset(Scheme& scheme, const RunConfig& config) {
  const std::int64_t bound_ns = asap::latency_bound_ns(config, scheme);
  packager_.reset();
  validator_ = Validator(config.validator);
  telemetry_.reset(bound_ns);
  buffer_.reset();
  arrivals_->reset(arrival_step_ns(bound_ns));
  publish();
  failed_ = false;
}

PipelineMemory Run::memory(const RunConfig& config, std::int64_t latency_bound_ns) noexcept {
  const std::size_t capacity =
      std::min(ring_capacity(config, latency_bound_ns), EventBuffer::kMaxCapacity);
  const std::size_t max_copied = config.max_copied > 0 ? config.max_copied : kMaxCopied;
  const std::size_t copies = std::min(capacity, max_copied) * sizeof(Event);
  return {.ring = EventBuffer::memory_bytes(capacity),
          .copies = copies,
          .log = RunLog::memory_bytes(std::min(config.log_rows, RunLog::kMaxRows)),
          .rest = LatencyHistogram::memory_bytes() +
                  ArrivalTimes::memory_bytes(ArrivalTimes::steps_for(capacity)) +
                  Packager::memory_bytes(capacity, max_copied, config.front_filter != nullptr) -
                  copies};
}

std::int64_t Run::arrival_step_ns(std::int64_t latency_bound_ns) noexcept {
  return std::max<std::int64_t>(latency_bound_ns / kStepsPerBound, 1);
}

void Run::begin(std::int64_t first_us, double speed) noexcept {
  axis_ = TimeAxis(first_us, speed);
  packager_.begin(axis_, first_us);
}

void Run::arrive(EventSpan events) {
  const std::uint64_t first = buffer_.tail();
  const std::size_t taken = buffer_.push(events);
  ring_gap_.kept(events.first(taken));
  if (taken < events.size()) ring_gap_.lost(events.subspan(taken));
  ages_->observe(events.first(taken), first,
                 [this](std::int64_t stamp) { return axis_.to_ns(stamp); });
  if (mask_) mask_->entered(taken, events.size() - taken);
}

void Run::publish() noexcept {
  const Rejections& counts = validator_.rejected();
  rejected_.nonmonotonic = counts.nonmonotonic;
  rejected_.out_of_bounds = counts.out_of_bounds;
  rejected_.bad_polarity = counts.bad_polarity;
  rejected_.bad_record = counts.bad_record;
  rejected_.before_start = counts.before_start;
  clock_resets_ = validator_.clock_resets();
  clock_offset_us_ = validator_.clock_offset_us();
}

Rejections Run::rejected() const noexcept {
  return {.nonmonotonic = rejected_.nonmonotonic,
          .out_of_bounds = rejected_.out_of_bounds,
          .bad_polarity = rejected_.bad_polarity,
          .bad_record = rejected_.bad_record,
          .before_start = rejected_.before_start};
}

Ledger Run::ledger(const Outside& outside) const noexcept {
  Ledger ledger = telemetry_.ledger();
  complete(ledger, outside.is_quiet ? validator_.rejected() : rejected(), outside);
  return ledger;
}

// The terms that the producer's side counts, after those of the consumer's.
void Run::complete(Ledger& ledger, const Rejections& rejected,
                   const Outside& outside) const noexcept {
  ledger.rejected = rejected.total();
  const std::uint64_t booked =
      ledger.filtered + ledger.discarded + ledger.stale + ledger.overflow + ledger.delivered;
  // What has been booked has been pushed, though a processor may see it before the tail.
  const std::uint64_t tail = std::max(buffer_.tail(), booked);
  const std::uint64_t overflow = buffer_.overflow();
  ledger.discarded += outside.thinned;
  ledger.overflow += overflow;
  ledger.pending = (outside.is_quiet ? buffer_.size() : tail - booked) + outside.waiting;
  ledger.received = outside.is_quiet
                        ? validator_.received()
                        : ledger.rejected + outside.thinned + overflow + tail + outside.waiting;
}

void Run::copy_stats_to(RunStats& stats, const Outside& outside) const noexcept {
  telemetry_.copy_to(stats.ledger, stats.latency, stats.packages);
  stats.rejected = outside.is_quiet ? validator_.rejected() : rejected();
  complete(stats.ledger, stats.rejected, outside);
  stats.clock_resets = outside.is_quiet ? validator_.clock_resets() : clock_resets_.load();
  stats.failed = failed_;
}

// Each stage measures the gap among the events that reached it; the largest is the gap of the run.
// Proof: for two delivered events, the last stage that lost any between them has seen both in a
// row, and no stage sees a longer gap than the run has. Only after the last delivered event do the
// gaps of two stages add up.
std::int64_t Run::gap_us(const GapMeter* in_front) const noexcept {
  const GapMeter& ring = packager_.gap();
  const bool is_over = buffer_.closed() && buffer_.size() == 0;
  std::int64_t gap_us = ring.longest_us();
  for (const GapMeter* front : {&ring_gap_, in_front}) {
    if (front == nullptr || front->lost_until_us() == kLongAgo) continue;
    gap_us = std::max(gap_us, front->longest_us());
    if (is_over) gap_us = std::max(gap_us, front->lost_until_us() - ring.kept_until_us());
  }
  return gap_us;
}

std::optional<KeptEvents> Run::kept() const {
  if (!mask_) return std::nullopt;
  return mask_->read();
}

}  // namespace asap::inline v0_1
