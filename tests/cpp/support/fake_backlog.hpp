// A backlog for a scheme alone, without ring and packager: the times of the waiting events in a
// list.
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "asap/schemes/scheme.hpp"

namespace asap::test {

class FakeBacklog final : public BacklogCounts {
 public:
  explicit FakeBacklog(std::vector<std::int64_t> times_ns) : times_ns_(std::move(times_ns)) {}

  // `count` events, all at time 0.
  static FakeBacklog of(std::size_t count) {
    return FakeBacklog(std::vector<std::int64_t>(count, 0));
  }

  std::size_t before(std::int64_t time_ns) const noexcept override {
    const auto end = std::lower_bound(times_ns_.begin(), times_ns_.end(), time_ns);
    return static_cast<std::size_t>(end - times_ns_.begin());
  }

  std::size_t about_before(std::int64_t time_ns) const noexcept override { return before(time_ns); }

  Backlog at(std::int64_t now_ns, bool due = false) const {
    return {.count = times_ns_.size(),
            .now_ns = now_ns,
            .oldest_ns = times_ns_.front(),
            .previous_start_ns = kLongAgo,
            .due = due,
            .counts = *this};
  }

 private:
  std::vector<std::int64_t> times_ns_;
};

}  // namespace asap::test
