// WorkByAge: the work that waits, by the age of its events, as a plan needs it: curves over slots
// of equal width, straight lines in between. Times and work are ns; work is what the events cost,
// fixed costs not included. One pass over the slots, no allocation.
// Source: notebooks/theory.md, section 6.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "asap/schemes/scheme.hpp"

namespace asap::inline v0_1 {

class WorkByAge {
 public:
  // The curves reach up to the age span_ns; each event costs event_ns.
  WorkByAge(const Backlog& backlog, double span_ns, double event_ns) noexcept
      : slot_ns_(span_ns / kSlots) {
    std::array<std::size_t, kSlots> older;
    const auto step_ns = static_cast<std::int64_t>(slot_ns_);
    backlog.counts.about_before_each(backlog.now_ns - step_ns, step_ns, older);
    work_[0] = done_[0] = 0.0;
    double lead_ns = 0.0;  // max over a of: a - C(a)
    double age_ns = 0.0;
    for (std::size_t k = 0; k < kSlots; ++k) {
      const auto younger = static_cast<std::int64_t>(backlog.count - older[k]);
      const double work_ns = event_ns * static_cast<double>(younger);
      age_ns += slot_ns_;
      lead_ns = std::max(lead_ns, age_ns - work_ns);
      work_[k + 1] = work_ns;
      done_[k + 1] = work_ns + lead_ns;
    }
  }

  // C(x), of the events up to this age.
  double up_to(double age_ns) const noexcept {
    const double slots = std::clamp(age_ns / slot_ns_, 0.0, static_cast<double>(kSlots));
    const std::size_t k = std::min(static_cast<std::size_t>(slots), kSlots - 1);
    return work_[k] + (slots - static_cast<double>(k)) * (work_[k + 1] - work_[k]);
  }

  // The age up to which so much work waits.
  double age_of(double work_ns) const noexcept { return inverse(work_, work_ns); }

  // The largest age x such that, if no more came, an event of any age a < x would be done at the
  // age a + time_ns: those up to x, oldest first, C(x) - C(a) + a <= time_ns.
  double age_done_within(double time_ns) const noexcept { return inverse(done_, time_ns); }

  // How long the largest package of the newest events takes that is over when its oldest gets
  // span_ns old, if events take `caution` times as long as they cost.
  double newest_only(double fixed_ns, double caution) const noexcept {
    const double span_ns = slot_ns_ * kSlots;
    const auto end_ns = [&](std::size_t slot) {
      return fixed_ns + caution * work_[slot] + slot_ns_ * static_cast<double>(slot);
    };
    const std::size_t k = last_slot([&](std::size_t slot) { return end_ns(slot) <= span_ns; });
    const double share = std::max(span_ns - end_ns(k), 0.0) / (end_ns(k + 1) - end_ns(k));
    const double work_ns = work_[k] + share * (work_[k + 1] - work_[k]);
    return fixed_ns + caution * work_ns;
  }

 private:
  static constexpr std::size_t kSlots = 32;
  using Curve = std::array<double, kSlots + 1>;

  // Returns the last slot k for which is(k) holds. It holds up to some slot and not beyond.
  template <class Is>
  static std::size_t last_slot(const Is& is) noexcept {
    std::size_t k = 0;
    for (std::size_t step = kSlots / 2; step > 0; step /= 2) {
      if (is(k + step)) k += step;
    }
    return k;
  }

  double inverse(const Curve& curve, double value) const noexcept {
    if (value <= 0.0) return 0.0;
    if (value >= curve.back()) return slot_ns_ * kSlots;
    const std::size_t k = last_slot([&](std::size_t slot) { return curve[slot] <= value; });
    const double share = (value - curve[k]) / (curve[k + 1] - curve[k]);
    return slot_ns_ * (static_cast<double>(k) + share);
  }

  double slot_ns_;
  Curve work_;
  Curve done_;
};

}  // namespace asap::inline v0_1
