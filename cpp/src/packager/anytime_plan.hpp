// AnytimePlan: how an anytime package keeps its budget. The raw events are cut into strata of equal
// count, in time order; before each of them the clock is read and the kept fraction is planned anew
// from the time that is left and from what an event has cost so far in this package, so that the
// package ends on time whatever the algorithm costs. The fixed cost is in the first stratum, and is
// no cost of its events; where there is but one, time is left for it. Where an event may cost
// more than expected a few of the first stratum come before the rest. A stratum that takes far
// longer than its like, between two that do not, has met an outage: the thread did not run.
// Arithmetic only: the time is handed in. O(1) per stratum. Source: notebooks/theory.md, section 7.
#pragma once

#include <cstddef>
#include <cstdint>

#include "asap/schemes/scheme.hpp"

namespace asap::inline v0_1 {

class AnytimePlan {
 public:
  static constexpr std::size_t kMaxStrata = 16;

  AnytimePlan() = default;
  // For the raw events of the decision, in a package that started at start_ns. An outage that takes
  // it more than grace_ns beyond its budget ends it: the strata that are left stay in the ring.
  AnytimePlan(const Decision& decision, std::int64_t start_ns, std::int64_t grace_ns) noexcept;

  struct Stratum {
    std::size_t begin = 0;  // raw events of the package
    std::size_t end = 0;    // begin == end: the package is finished
    double gamma = 1.0;
    bool is_last = false;  // nothing follows that could make up for a chance in its number
  };

  // Raw events in a stratum of a package of so many.
  static std::size_t longest_stratum(std::size_t raw) noexcept;

  // The stratum to process from now on; `size` events were kept of the one before.
  Stratum next(std::int64_t now_ns, std::size_t size) noexcept;

  // What it was until the end of the first stratum, fixed cost included; nothing before the second.
  struct Part {
    std::size_t size = 0;
    std::int64_t time_ns = 0;
  };
  Part first() const noexcept { return first_; }

  // Returns how much of the package's time so far went into outages that show; 0 before the second
  // stratum.
  std::int64_t outage_ns() const noexcept;

 private:
  double gamma(std::int64_t now_ns) const noexcept;
  double first_events_ns(double part_ns, double size) const noexcept;
  void judge(double stratum_ns, double size) noexcept;

  std::size_t raw_ = 0;
  std::size_t strata_ = 0;
  std::size_t probe_ = 0;
  std::size_t parts_ = 0;  // handed out: the probe and ...
  std::size_t done_ = 0;   // ... strata
  double planned_ = 0;     // events to keep of all
  std::int64_t start_ns_ = 0;
  std::int64_t end_ns_ = 0;  // of the budget
  std::int64_t grace_ns_ = 0;
  std::int64_t fixed_end_ns_ = 0;  // as expected, of the fixed cost
  double weight_ = 1;              // events that spent_ns_ stands for, those of the prior included
  double spent_ns_ = 0;
  std::int64_t stratum_start_ns_ = 0;
  Part first_;
  double outage_ns_ = 0;   // certainly
  double suspect_ns_ = 0;  // of the last stratum: an outage, or events that have become dear
};

}  // namespace asap::inline v0_1
