#include "packager/rate_meter.hpp"

namespace asap {

void RateMeter::observe(std::size_t count, std::int64_t oldest_ns,
                        std::int64_t newest_ns) noexcept {
  if (end_ == 0) {
    newest_ = {oldest_ns, 0};
    marks_[end_++] = newest_;
  }
  if (newest_ns > newest_.time_ns) {
    newest_ = {newest_ns, total_ + (oldest_ns < newest_ns ? count - 1 : 0)};
  }
  total_ += count;
  if (newest_ns - mark(end_ - 1).time_ns >= kMarkEveryNs) marks_[end_++ % kMarks] = newest_;
  while (oldest_ + 1 < end_ && newest_ns - mark(oldest_ + 1).time_ns >= kWindowNs) ++oldest_;
}

RateMeter::Window RateMeter::window() const noexcept {
  const std::int64_t elapsed_ns = newest_.time_ns - mark(oldest_).time_ns;
  if (end_ == 0 || elapsed_ns < kWindowNs) return {total_, kWindowNs};
  return {newest_.before - mark(oldest_).before, elapsed_ns};
}

}  // namespace asap
