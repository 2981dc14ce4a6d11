#include "study/clairvoyant.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <string>
#include <vector>

#include "asap/core/time.hpp"
#include "core/check.hpp"

namespace asap::inline v0_1 {

// ---- the smallest latency ----

namespace {

// Events that no boundary parts.
struct Bin {
  std::int64_t oldest_ns;
  std::int64_t newest_ns;
  std::size_t end;  // number of events up to and with this bin
};

std::vector<Bin> bins_of(EventSpan events, double bin_us) {
  const TimeAxis axis(events.front().t, 1.0);
  const double bin_ns = bin_us * 1e3;
  std::vector<Bin> bins;
  double last_slot = 0;
  for (std::size_t i = 0; i < events.size(); ++i) {
    const std::int64_t time_ns = axis.to_ns(events[i].t);
    const double slot =
        bin_ns > 0 ? std::floor(static_cast<double>(time_ns) / bin_ns) : static_cast<double>(i);
    if (bins.empty() || slot != last_slot) bins.push_back({time_ns, time_ns, i});
    last_slot = slot;
    bins.back().newest_ns = time_ns;
    bins.back().end = i + 1;
  }
  return bins;
}

class Window {
 public:
  Window(EventSpan events, const LinearCost& cost, double bin_us)
      : cost_(cost), bins_(bins_of(events, bin_us)), done_ns_(bins_.size() + 1, kLongAgo) {}

  // The largest latency when all bins that wait are served whenever the algorithm is free.
  std::int64_t greedy_latency_ns() const {
    std::int64_t worst_ns = 0;
    std::int64_t free_ns = kLongAgo;
    for (std::size_t first = 0; first < bins_.size();) {
      free_ns = std::max(free_ns, bins_[first].newest_ns);
      std::size_t end = first + 1;
      while (end < bins_.size() && bins_[end].newest_ns <= free_ns) ++end;
      free_ns = end_ns(first, end, free_ns);
      worst_ns = std::max(worst_ns, free_ns - bins_[first].oldest_ns);
      first = end;
    }
    return worst_ns;
  }

  // Whether packages exist that keep this latency.
  bool is_feasible(std::int64_t latency_ns) {
    for (std::size_t end = 1; end <= bins_.size(); ++end) {
      done_ns_[end] = earliest_end_ns(end, latency_ns);
      if (done_ns_[end] == kNever) return false;  // more bins would not be done any earlier
    }
    return true;
  }

 private:
  // When the bins before `end` can be done at the earliest, given that for fewer bins.
  std::int64_t earliest_end_ns(std::size_t end, std::int64_t latency_ns) const {
    const std::int64_t ready_ns = bins_[end - 1].newest_ns;
    std::int64_t earliest_ns = kNever;
    for (std::size_t first = end; first-- > 0;) {
      const std::int64_t oldest_ns = bins_[first].oldest_ns;
      if (ready_ns - oldest_ns > latency_ns) break;
      const std::int64_t free_ns = done_ns_[first];
      const std::int64_t done_ns = end_ns(first, end, std::max(free_ns, ready_ns));
      if (done_ns - oldest_ns <= latency_ns) earliest_ns = std::min(earliest_ns, done_ns);
      if (free_ns <= ready_ns) break;  // larger packages start no earlier, last longer, are older
    }
    return earliest_ns;
  }

  // When a package of the bins [first, end) that may start at start_ns is done.
  std::int64_t end_ns(std::size_t first, std::size_t end, std::int64_t start_ns) const {
    const std::size_t size = bins_[end - 1].end - (first > 0 ? bins_[first - 1].end : 0);
    std::int64_t best_ns = end_ns(size, cost_.start_ns(start_ns));
    // The cost per event is that of the start: it may pay to wait for a cheaper millisecond.
    const auto steps = static_cast<std::int64_t>(cost_.config().drift.size());
    for (std::int64_t step = start_ns / LinearCost::kDriftStepNs + 1; step < steps; ++step) {
      const std::int64_t later_ns = cost_.start_ns(step * LinearCost::kDriftStepNs);
      if (later_ns >= best_ns) break;
      best_ns = std::min(best_ns, end_ns(size, later_ns));
    }
    return best_ns;
  }

  std::int64_t end_ns(std::size_t size, std::int64_t start_ns) const noexcept {
    return cost_.done_ns(start_ns, cost_.package(0, start_ns).of(size));
  }

  const LinearCost& cost_;
  std::vector<Bin> bins_;
  std::vector<std::int64_t> done_ns_;  // [i]: when the first i bins can be done at the earliest
};

}  // namespace

std::int64_t clairvoyant_latency_ns(EventSpan events, const LinearCost& cost, double bin_us) {
  require(bin_us >= 0 && bin_us <= 1e6, "bin_us", bin_us, "must be between 0 and 1e6 us");
  require(cost.config().noise == 0, "noise", cost.config().noise,
          "must be 0: the draws of a noisy cost cannot be foreseen");
  if (events.empty()) return 0;
  Window window(events, cost, bin_us);
  std::int64_t too_short_ns = 0;
  std::int64_t enough_ns = window.greedy_latency_ns();
  while (enough_ns - too_short_ns > 1) {
    const std::int64_t latency_ns = std::midpoint(too_short_ns, enough_ns);
    (window.is_feasible(latency_ns) ? enough_ns : too_short_ns) = latency_ns;
  }
  return enough_ns;
}

// ---- the most events ----

namespace {

constexpr double kLongestNs = 9e15;  // a double counts nanoseconds exactly up to here
constexpr double kMaxSteps = 8e10;   // a minute at most

// The earliest ends at which `fewest`, `fewest` + 1, ... events can be done, in rising order.
struct Ends {
  std::size_t fewest = 0;
  std::vector<double> ns;

  std::size_t max() const noexcept { return fewest + ns.size() - 1; }
  // Numbers of events that can be done by this time, less the fewest.
  std::size_t done_by(double time_ns) const noexcept {
    return static_cast<std::size_t>(std::ranges::upper_bound(ns, time_ns) - ns.begin());
  }
};

class Programme {
 public:
  Programme(EventSpan events, const LinearCost& cost, double latency_ns)
      : alpha_ns_(1e3 * cost.config().alpha_us),
        beta_ns_(cost.config().beta_ns),
        latency_ns_(latency_ns) {
    times_ns_.reserve(events.size());
    for (const Event& event : events) {
      const double time_ns = 1e3 * static_cast<double>(event.t - events.front().t);
      times_ns_.push_back(times_ns_.empty() ? time_ns : std::max(time_ns, times_ns_.back()));
    }
    longest_ = longest_block();
    rows_.resize(longest_ + 1);
  }

  double length_ns() const noexcept { return times_ns_.back(); }

  // Events, from the first on, for which so many steps are enough.
  std::size_t affordable(double max_steps) const noexcept {
    std::size_t fits = 0;
    std::size_t too_many = times_ns_.size();
    if (steps(times_ns_.size()) <= max_steps) return times_ns_.size();
    while (too_many - fits > 1) {
      const std::size_t count = fits + (too_many - fits) / 2;
      (steps(count) <= max_steps ? fits : too_many) = count;
    }
    return fits;
  }

  std::uint64_t max() {
    row(0).ns = {0};
    for (std::size_t count = 1; count <= times_ns_.size(); ++count) {
      Ends& ends = row(count);
      ends = row(count - 1);  // the newest event is discarded
      end_blocks(count, ends);
      forget_the_hopeless(count, ends);
    }
    return row(times_ns_.size()).max();
  }

 private:
  double cost_ns(std::size_t size) const noexcept {
    return std::max(1.0, std::round(alpha_ns_ + beta_ns_ * static_cast<double>(size)));
  }

  // The most events of a block: they arrive within L and cost at most L.
  std::size_t longest_block() const noexcept {
    std::size_t longest = 0;
    for (std::size_t i = 0, first = 0; i < times_ns_.size(); ++i) {
      while (times_ns_[i] - times_ns_[first] > latency_ns_) ++first;
      if (i + 1 - first > longest && cost_ns(longest + 1) <= latency_ns_) ++longest;
    }
    return longest;
  }

  // The maximum for the first `count` events: blocks times numbers to look at.
  double steps(std::size_t count) const noexcept {
    double sum = 0;
    std::size_t first = 0;  // first event of the last L
    std::size_t past = 0;   // first event after the next L
    for (std::size_t i = 0; i < count; ++i) {
      while (times_ns_[i] - times_ns_[first] > latency_ns_) ++first;
      while (past < count && times_ns_[past] - times_ns_[i] <= latency_ns_) ++past;
      sum += static_cast<double>(std::min(i + 1 - first, longest_)) * static_cast<double>(past - i);
    }
    return sum;
  }

  Ends& row(std::size_t count) noexcept { return rows_[count % rows_.size()]; }

  // Blocks that end with the newest of `count` events.
  void end_blocks(std::size_t count, Ends& ends) {
    const double newest_ns = times_ns_[count - 1];
    for (std::size_t size = 1; size <= std::min(count, longest_); ++size) {
      const double work_ns = cost_ns(size);
      const double latest_ns = times_ns_[count - size] + latency_ns_ - work_ns;
      if (latest_ns < newest_ns) break;
      const Ends& before = row(count - size);
      const std::size_t end = before.done_by(latest_ns);
      if (end == 0) continue;
      // Among the numbers that are done when the block can start, only the largest matters.
      std::size_t first = std::max<std::size_t>(before.done_by(newest_ns), 1) - 1;
      const std::size_t min = before.fewest + size;
      if (min + first < ends.fewest) first = ends.fewest - min;
      if (first >= end) continue;
      const std::size_t max = min + end - 1;
      if (max > ends.max()) ends.ns.resize(max - ends.fewest + 1, kNeverNs);
      const double* const from = before.ns.data() + first;
      double* const to = ends.ns.data() + (min + first - ends.fewest);
      for (std::size_t i = 0; i < end - first; ++i) {
        const double end_ns = std::max(from[i], newest_ns) + work_ns;
        to[i] = end_ns < to[i] ? end_ns : to[i];
      }
    }
    for (std::size_t i = ends.ns.size() - 1; i > 0; --i) {
      ends.ns[i - 1] = std::min(ends.ns[i - 1], ends.ns[i]);
    }
  }

  // The schedule with the most events may rest until its end. Until then another one catches up by
  // the events that arrive at most, so one that lags by as many never wins.
  void forget_the_hopeless(std::size_t count, Ends& ends) const {
    const double end_ns = ends.ns.back();
    const auto arrived = std::ranges::lower_bound(times_ns_, end_ns) - times_ns_.begin();
    const std::ptrdiff_t lead = arrived - static_cast<std::ptrdiff_t>(count);
    const std::size_t kept = lead > 1 ? static_cast<std::size_t>(lead) : 1;
    if (kept >= ends.ns.size()) return;
    const std::size_t gone = ends.ns.size() - kept;
    ends.ns.erase(ends.ns.begin(), ends.ns.begin() + static_cast<std::ptrdiff_t>(gone));
    ends.fewest += gone;
  }

  static constexpr double kNeverNs = std::numeric_limits<double>::infinity();

  double alpha_ns_;
  double beta_ns_;
  double latency_ns_;
  std::size_t longest_;
  std::vector<double> times_ns_;
  std::vector<Ends> rows_;  // rows of the last `longest_` + 1 counts
};

}  // namespace

std::uint64_t exact_clairvoyant(EventSpan events, const LinearCost& cost, double latency_us) {
  require(latency_us > 0 && latency_us <= 3.6e9, "latency_us", latency_us,
          "must be above 0 and at most 3.6e9");
  require(cost.config().drift.empty(), "drift", cost.config().drift.size(),
          "the exact clairvoyant takes one cost for all: leave it out");
  require(cost.config().outages.empty(), "outages", cost.config().outages.size(),
          "the exact clairvoyant takes one cost for all: leave them out");
  if (events.empty()) return 0;
  Programme programme(events, cost, std::floor(1e3 * latency_us));
  require(programme.length_ns() <= kLongestNs, "duration", programme.length_ns() * 1e-9,
          "must be at most 9e6 s: give a part of the recording");
  const std::size_t affordable = programme.affordable(kMaxSteps);
  require(affordable == events.size(), "events", events.size(),
          "too many for an exact answer at this rate: give the first " +
              std::to_string(affordable) + " or fewer");
  return programme.max();
}

}  // namespace asap::inline v0_1
