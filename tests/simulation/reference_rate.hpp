// ReferenceRate: the rate of the events that have left the ring, over the last millisecond or more:
// from the newest mark that is that old. Marks are all kept and searched from behind.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace asap::simulation {

class ReferenceRate {
 public:
  void observe(std::size_t count, std::int64_t oldest_ns, std::int64_t newest_ns) {
    if (marks_.empty()) marks_.push_back(newest_ = {oldest_ns, 0});
    if (newest_ns > newest_.time_ns) {
      newest_ = {newest_ns, total_ + (oldest_ns < newest_ns ? count - 1 : 0)};
    }
    total_ += count;
    if (newest_.time_ns - marks_.back().time_ns >= 62'500) marks_.push_back(newest_);
  }

  double per_second() const {
    if (marks_.empty() || newest_.time_ns - marks_.front().time_ns < 1'000'000) {
      return static_cast<double>(total_) * 1e9 / 1e6;
    }
    const Mark* begin = &marks_.back();
    while (newest_.time_ns - begin->time_ns < 1'000'000) --begin;
    return static_cast<double>(newest_.before - begin->before) * 1e9 /
           static_cast<double>(newest_.time_ns - begin->time_ns);
  }

 private:
  struct Mark {
    std::int64_t time_ns;
    std::uint64_t before;
  };
  std::vector<Mark> marks_;
  Mark newest_{};
  std::uint64_t total_ = 0;
};

}  // namespace asap::simulation
