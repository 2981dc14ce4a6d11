#include "asap/schemes/rate_meter.hpp"

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

double RateMeter::per_second() const noexcept {
  if (end_ == 0) return 0.0;
  const std::int64_t elapsed_ns = newest_.time_ns - mark(oldest_).time_ns;
  if (elapsed_ns < kWindowNs) return static_cast<double>(total_) * (1e9 / kWindowNs);
  return static_cast<double>(newest_.before - mark(oldest_).before) * 1e9 /
         static_cast<double>(elapsed_ns);
}

}  // namespace asap
