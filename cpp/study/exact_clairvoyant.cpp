#include "study/exact_clairvoyant.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "asap/core/check.hpp"

namespace asap {
namespace {

constexpr double kLongestNs = 9e15;  // a double counts nanoseconds exactly up to here

// The earliest ends at which `fewest`, `fewest` + 1, ... events can be done, in rising order.
struct Ends {
  std::size_t fewest = 0;
  std::vector<double> ns;

  std::size_t most() const noexcept { return fewest + ns.size() - 1; }
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
  std::size_t affordable(double most_steps) const noexcept {
    std::size_t fits = 0;
    std::size_t too_many = times_ns_.size();
    if (steps(times_ns_.size()) <= most_steps) return times_ns_.size();
    while (too_many - fits > 1) {
      const std::size_t count = fits + (too_many - fits) / 2;
      (steps(count) <= most_steps ? fits : too_many) = count;
    }
    return fits;
  }

  std::uint64_t most() {
    row(0).ns = {0};
    for (std::size_t count = 1; count <= times_ns_.size(); ++count) {
      Ends& ends = row(count);
      ends = row(count - 1);  // the newest event is discarded
      end_blocks(count, ends);
      forget_the_hopeless(count, ends);
    }
    return row(times_ns_.size()).most();
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

  // At most, for the first `count` events: blocks times numbers to look at.
  double steps(std::size_t count) const noexcept {
    double sum = 0;
    std::size_t first = 0;  // of the events of the last L
    std::size_t past = 0;   // of those after the next L
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
      const std::size_t least = before.fewest + size;
      if (least + first < ends.fewest) first = ends.fewest - least;
      if (first >= end) continue;
      const std::size_t most = least + end - 1;
      if (most > ends.most()) ends.ns.resize(most - ends.fewest + 1, kNeverNs);
      const double* const from = before.ns.data() + first;
      double* const to = ends.ns.data() + (least + first - ends.fewest);
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
  std::vector<Ends> rows_;  // for the last `longest_` + 1 counts
};

}  // namespace

std::uint64_t exact_clairvoyant(EventSpan events, const LinearCost& cost, double latency_us,
                                double most_steps) {
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
  const std::size_t affordable = programme.affordable(most_steps);
  require(affordable == events.size(), "events", events.size(),
          "too many for an exact answer at this rate: give the first " +
              std::to_string(affordable) + " or fewer");
  return programme.most();
}

}  // namespace asap
