// RecordingIntake: how the events of a recording come to the ring: pushed at their time, their ages
// noted for the scheme, and on request whether they found room. The producer's thread; O(1) per
// event.
#pragma once

#include <cstdint>

#include "asap/buffer/age_slots.hpp"
#include "asap/buffer/event_buffer.hpp"
#include "asap/core/time.hpp"
#include "asap/packager/kept_mask.hpp"
#include "asap/runner/run_config.hpp"

namespace asap {

class RecordingIntake {
 public:
  // The buffer outlives the intake, and so does `mask`, which may be none.
  RecordingIntake(EventBuffer& buffer, std::int64_t latency_bound_ns, KeptMask* mask)
      : buffer_(buffer), ages_(age_slot_ns(latency_bound_ns)), mask_(mask) {}

  const AgeSlots& ages() const noexcept { return ages_; }

  // These have arrived; what finds the ring full is overflow.
  void push(EventSpan events, const TimeAxis& axis) {
    const std::uint64_t first = buffer_.tail();
    const std::size_t taken = buffer_.push(events);
    ages_.observe(events.first(taken), first,
                  [&](std::int64_t stamp) { return axis.to_ns(stamp); });
    if (mask_ != nullptr) mask_->entered(taken, events.size() - taken);
  }

 private:
  EventBuffer& buffer_;
  AgeSlots ages_;
  KeptMask* const mask_;
};

}  // namespace asap
