// KeptTimes: when the kept events of the package in work arrived, in runs of one time. The filter
// loses the ring index of an event, so the packager notes it before. One thread; no allocation
// after construction.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace asap {

class KeptTimes {
 public:
  struct Run {
    std::size_t end;  // of the kept events; the run begins where the one before ends
    std::int64_t time_ns;
  };

  explicit KeptTimes(std::size_t runs) { runs_.reserve(runs); }

  void clear() noexcept { runs_.clear(); }

  // The kept events up to `end`, beyond those noted before, came at this time. At most as many runs
  // as said at construction.
  void note(std::size_t end, std::int64_t time_ns) noexcept {
    if (end > (runs_.empty() ? 0 : runs_.back().end)) runs_.push_back({end, time_ns});
  }

  const std::vector<Run>& runs() const noexcept { return runs_; }

 private:
  std::vector<Run> runs_;
};

}  // namespace asap
