#include "study/clairvoyant.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <vector>

#include "asap/core/check.hpp"
#include "asap/core/time.hpp"

namespace asap {
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
          "must be 0: nobody foresees the draws");
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

}  // namespace asap
