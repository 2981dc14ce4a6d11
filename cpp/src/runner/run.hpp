// Run: what every run consists of, whatever its clock: the validator, the ring, the times of its
// events, the packager, telemetry and the ledger. Simulator, Replay and Pipeline drive it; they
// differ in the clock, and in how events come to the ring.
//
// Producer and consumer as in EventBuffer; the accessors say whose each part is. Memory is taken in
// the constructor, but for the rows of a recording's log and its mask.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>

#include "asap/core/time.hpp"
#include "asap/filter/validator.hpp"
#include "asap/runner/run_config.hpp"
#include "buffer/age_slots.hpp"
#include "buffer/arrival_times.hpp"
#include "buffer/event_buffer.hpp"
#include "core/atomics.hpp"
#include "core/check.hpp"
#include "packager/kept_mask.hpp"
#include "packager/packager.hpp"
#include "telemetry/telemetry.hpp"

namespace asap::inline v0_1 {

// Throws for an empty function.
template <class Algorithm>
Algorithm&& given(Algorithm&& algorithm) {
  if (!algorithm) throw_bad_value("algorithm", "none", "give what the events are for");
  return std::forward<Algorithm>(algorithm);
}

class Run {
 public:
  // A recording's events come at their timestamps; a camera's when they are pushed, and its log
  // keeps the newest rows alone.
  enum class Source { recording, camera };

  static constexpr std::size_t kMaxCopied = std::size_t{1} << 17;  // unless configured

  // The scheme outlives the run.
  Run(Scheme& scheme, const RunConfig& config, Source source);

  // What the run of a camera takes from the heap, all of it in its constructor.
  static PipelineMemory memory(const RunConfig& config, std::int64_t latency_bound_ns) noexcept;

  // The step to which the arrivals of a camera's events are known.
  static std::int64_t arrival_step_ns(std::int64_t latency_bound_ns) noexcept;

  // Begins another run of a camera, in place and as constructed: takes no memory. Neither side is
  // at work. Throws what the constructor would for this scheme as it is now: then nothing has
  // changed.
  void reset(Scheme& scheme, const RunConfig& config);

  // Producer, before the first push: the timestamp of the first event, which ties timestamps to run
  // time.
  void begin(std::int64_t first_us, double speed = 1.0) noexcept;
  const TimeAxis& axis() const noexcept { return axis_; }

  // Producer. Events of a recording have arrived; those that find the ring full are overflow.
  void arrive(EventSpan events);

  // Producer, once the validator has seen events: what it has counted, for other threads.
  void publish() noexcept;
  // Any thread: what was last published.
  Rejections rejected() const noexcept;
  std::int64_t clock_offset_us() const noexcept { return clock_offset_us_; }

  // What the driver of a run knows of it.
  struct Outside {
    bool is_quiet;              // neither side is at work, so every term is counted on its own
    std::uint64_t thinned = 0;  // discarded in front of the ring
    std::uint64_t waiting = 0;  // received, and not yet in the ring
  };

  // Where every event went. Any thread: a snapshot, in which a package that is being booked may
  // still count as pending.
  Ledger ledger(const Outside& outside) const noexcept;

  // All that is counted but the gap. Any thread: what the consumer's side has booked is of one
  // moment. Allocates nothing.
  void copy_stats_to(RunStats& stats, const Outside& outside) const noexcept;

  // Calls what works for this run: where it throws, the run has failed.
  template <class Work>
  void guard(const Work& work) {
    try {
      work();
    } catch (...) {
      fail();
      throw;
    }
  }
  void fail() noexcept { failed_ = true; }

  // The gap (GapMeter) between delivered events, wherever those between them were lost. Any thread.
  // `in_front`: measured where events were thinned before they came to the ring.
  std::int64_t gap_us(const GapMeter* in_front = nullptr) const noexcept;

  // Which events were delivered, if asked for. Read it once the run is over.
  std::optional<KeptEvents> kept() const;

  EventBuffer& buffer() noexcept { return buffer_; }
  const EventBuffer& buffer() const noexcept { return buffer_; }
  // The producer's.
  Validator& validator() noexcept { return validator_; }
  const Validator& validator() const noexcept { return validator_; }
  ArrivalTimes& arrivals() noexcept { return *arrivals_; }  // of a camera
  // The consumer's.
  Packager& packager() noexcept { return packager_; }
  Telemetry& telemetry() noexcept { return telemetry_; }
  const Telemetry& telemetry() const noexcept { return telemetry_; }
  std::int64_t latency_bound_ns() const noexcept { return telemetry_.latency.bound_ns(); }

 private:
  void complete(Ledger& ledger, const Rejections& rejected, const Outside& outside) const noexcept;

  const std::unique_ptr<KeptMask> mask_;
  Validator validator_;
  Telemetry telemetry_;
  EventBuffer buffer_;
  GapMeter ring_gap_;  // the producer's: of a recording, where events find the ring full
  const std::unique_ptr<AgeSlots> ages_;
  const std::unique_ptr<ArrivalTimes> arrivals_;
  Packager packager_;
  TimeAxis axis_;
  // What the validator has counted by the end of the last push.
  struct {
    Relaxed<std::uint64_t> nonmonotonic, out_of_bounds, bad_polarity, bad_record, before_start;
  } rejected_;
  Relaxed<std::uint64_t> clock_resets_;
  Relaxed<std::int64_t> clock_offset_us_;
  Relaxed<bool> failed_;
};

}  // namespace asap::inline v0_1
