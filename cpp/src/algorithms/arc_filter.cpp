#include "algorithms/arc_filter.hpp"

#include "asap/core/check.hpp"

namespace asap {
namespace {

RecentTimes::Time checked(std::int64_t window_us) {
  require(0 <= window_us && window_us <= RecentTimes::kMaxWindow_us, "filter_us", window_us,
          "must be 0 to 500000000 us");
  return static_cast<RecentTimes::Time>(window_us);
}

}  // namespace

ArcFilter::ArcFilter(const SensorFrame& frame, std::int64_t window_us)
    : width_(frame.width()),
      window_us_(checked(window_us)),
      times_(2 * width_ * frame.height(), 0) {}

}  // namespace asap
