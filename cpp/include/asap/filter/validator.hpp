// Validator: the door of the library. Behind it timestamps never go back, pixels lie inside the
// sensor and polarity is 0 or 1; what does not fit is dropped, clamped or refused, and always
// counted.
//
// One thread (the producer's). O(n), no allocation after construction. A block without a fault
// passes in place, without a copy; a block with one, or whose timestamps are shifted, passes
// through a fixed scratch buffer. A timestamp that goes back by less than kNewEpoch_us is a fault;
// by more, the sensor's clock was reset: a new epoch starts, and time continues one microsecond
// after the last event. A validator that doubts resets believes one only after kStays timestamps in
// a row confirm it; fewer are faults. With a warm-up, events within it after the first one, or
// after such a reset, are before the start.
//
//   Validator validator{{.width = 346, .height = 260}};
//   validator.check(events, [&](EventSpan good) { tracker.process(good); });
//   if (validator.rejected().total() > 0) fail("some events do not fit");
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>

#include "asap/core/event.hpp"
#include "asap/core/nonblocking.hpp"

namespace asap::inline v0_1 {

class BitLog;

enum class OnBad { drop, clamp, raise };

// Events that did not pass, by reason.
struct Rejections {
  std::uint64_t nonmonotonic = 0;
  std::uint64_t out_of_bounds = 0;
  std::uint64_t bad_polarity = 0;
  std::uint64_t bad_record = 0;    // unreadable, or a timestamp beyond kMaxRawStamp_us
  std::uint64_t before_start = 0;  // during the warm-up, also if something else is wrong

  std::uint64_t total() const noexcept {
    return nonmonotonic + out_of_bounds + bad_polarity + bad_record + before_start;
  }
  friend bool operator==(const Rejections&, const Rejections&) = default;
};

// Events that passed, but not as they came. One event may count in several fields.
struct Repairs {
  std::uint64_t normalised_polarity = 0;  // p > 0 became 1, p < 0 became 0
  std::uint64_t lifted_stamps = 0;  // set to the last timestamp: tolerated disorder, OnBad::clamp
  std::uint64_t clamped_positions = 0;  // moved to the edge of the sensor: OnBad::clamp

  friend bool operator==(const Repairs&, const Repairs&) = default;
};

struct ValidatorConfig {
  int width = 0;   // px; 0: x is not checked
  int height = 0;  // px; 0: y is not checked
  OnBad on_bad = OnBad::drop;
  // Both count whole microseconds.
  std::chrono::nanoseconds
      reorder_tolerance{};  // a timestamp that goes back by this is lifted, not bad
  std::chrono::nanoseconds warmup_discard{};  // what a camera sends first may be of the run before
};

class Validator {
 public:
  // Times beyond +-2^52 us (142 years) would overflow when counted in nanoseconds.
  static constexpr std::int64_t kMaxStamp_us = std::int64_t{1} << 52;
  // A timestamp as it comes stays below by 35 years, so that time can continue after a damaged one.
  static constexpr std::int64_t kMaxRawStamp_us = kMaxStamp_us - (std::int64_t{1} << 50);
  static constexpr std::int64_t kNewEpoch_us = 1'000'000;

  explicit Validator(ValidatorConfig config = {});

  // Calls sink(EventSpan) with runs of good events, in order; a run is valid during the call.
  // With OnBad::raise throws std::invalid_argument, which names field, value and the number of the
  // event, once everything before that event has been sunk.
  template <class Sink>
  void check(EventSpan events, Sink&& sink) {
    std::size_t run = 0;  // first event of the clean run that is not sunk yet
    for (std::size_t at = 0; at < events.size();) {
      const EventSpan block = events.subspan(at, std::min(kBlock, events.size() - at));
      if (pass_clean(block)) {
        at += block.size();
        if (clock_offset_us_ == 0) continue;
        sink(shifted(block));  // the run is empty: no event passes in place in such an epoch
        run = at;
        continue;
      }
      if (at > run) sink(events.subspan(run, at - run));
      const Repaired repaired = repair(block, events.subspan(at));
      if (repaired.kept > 0) sink(EventSpan{scratch_.data(), repaired.kept});
      if (repaired.fault != Fault::none) {
        exempt([&] { refuse(block[repaired.read], repaired.fault); });  // it throws: OnBad::raise
      }
      at += block.size();
      run = at;
    }
    if (events.size() > run) sink(events.subspan(run));
  }

  // For live events, among which a few timestamps may be stray. The first events of a reset are
  // dropped if those that confirm it come with a later check().
  void doubt_resets() noexcept { doubts_resets_ = config_.on_bad != OnBad::raise; }
  static constexpr std::size_t kStays = 32;

  // The sensor's clock begins anew with this timestamp, whatever it is: time continues 1 us after
  // the last event. Nothing happens before the first event.
  void begin_epoch(std::int64_t first_us) noexcept;

  // received() = events sunk + rejected().total()
  std::uint64_t received() const noexcept { return received_; }
  const Rejections& rejected() const noexcept { return rejected_; }
  const Repairs& repaired() const noexcept { return repairs_; }
  std::uint64_t normalised_polarity() const noexcept { return repairs_.normalised_polarity; }

  // Timestamp of the last event that passed; meaningless before the first.
  std::int64_t last_us() const noexcept { return last_us_; }

  // Epochs: how often the sensor's clock began anew, and what is now added to its timestamps.
  std::uint64_t clock_resets() const noexcept { return clock_resets_; }
  std::int64_t clock_offset_us() const noexcept { return clock_offset_us_; }

  const ValidatorConfig& config() const noexcept { return config_; }

 private:
  friend class KeptMask;

  static constexpr std::size_t kBlock = 256;

  enum class Fault { none, bad_record, out_of_bounds, nonmonotonic, before_start };
  struct Repaired {
    std::size_t kept;           // events in the scratch buffer
    std::size_t read;           // index in the block where the repair ended
    Fault fault = Fault::none;  // of the event at `read`, if it is to be refused
  };

  bool pass_clean(EventSpan block);
  EventSpan shifted(EventSpan block) noexcept;
  Repaired repair(EventSpan block, EventSpan rest);
  Fault mend(Event& event, EventSpan rest) noexcept;
  bool stays(EventSpan rest) noexcept;
  bool warms_up(const Event& event) noexcept;
  void count(Fault fault) noexcept;
  [[noreturn]] void refuse(const Event& event, Fault fault) const;

  ValidatorConfig config_;
  std::int64_t reorder_tolerance_us_;
  std::int64_t warmup_discard_us_;
  BitLog* passed_ = nullptr;  // one bit per event that has come, 1 = sunk; the mask's
  std::uint32_t max_x_;
  std::uint32_t max_y_;
  static constexpr std::int64_t kNone_us = -kMaxRawStamp_us;
  std::int64_t last_us_ = kNone_us;  // timestamp of the last event that passed
  bool warming_up_;
  std::int64_t warm_up_first_us_ = kMaxStamp_us;  // the warm-up counts from this timestamp
  std::int64_t warm_up_last_us_ = kMaxStamp_us;
  bool doubts_resets_ = false;
  std::size_t far_back_ = 0;  // in a row, at the end of what has come
  std::int64_t clock_offset_us_ = 0;
  std::uint64_t clock_resets_ = 0;
  std::uint64_t received_ = 0;
  Rejections rejected_;
  Repairs repairs_;
  std::array<Event, kBlock> scratch_{};  // written at construction: no page is missing later
};

}  // namespace asap::inline v0_1
