#include "asap/telemetry/run_log.hpp"

#include <algorithm>

#include "core/atomics.hpp"
#include "core/check.hpp"

namespace asap::inline v0_1 {

void RunLog::add_block() {
  blocks_.push_back(detail::allocate<PackageRecord>(block_rows_, "log_rows", block_rows_));
  begin(blocks_.back());
}

PackageTotals RunLog::totals() const noexcept {
  return {.count = load_relaxed(totals_.count),
          .to_gamma = load_relaxed(totals_.to_gamma),
          .size = load_relaxed(totals_.size),
          .size_max = load_relaxed(totals_.size_max),
          .processing_ns = load_relaxed(totals_.processing_ns),
          .gamma_min = load_relaxed(totals_.gamma_min)};
}

PackageRow RunLog::operator[](std::size_t i) const noexcept {
  const PackageRecord& record = row(i);
  const std::int64_t span_ns = axis_.to_ns(record.t_last) - axis_.to_ns(record.t_first);
  const std::int64_t end_ns = record.start_ns + record.processing_ns;
  const auto size = static_cast<double>(record.size);
  return {
      .index = static_cast<std::int64_t>(i),
      .start_us = axis_.to_us(record.start_ns),
      .processing_us = static_cast<double>(record.processing_ns) * 1e-3,
      .t_first = record.t_first,
      .t_last = record.t_last,
      .offered = static_cast<std::int64_t>(record.offered),
      .size = static_cast<std::int64_t>(record.size),
      .gamma = size / static_cast<double>(record.offered - record.filtered),
      .event_rate =
          static_cast<double>(record.rate_events) * 1e9 / static_cast<double>(record.rate_ns),
      .rate = size * 1e9 / static_cast<double>(std::max<std::int64_t>(span_ns, 1000)),
      .margin_us = static_cast<double>(record.processing_ns - span_ns) * 1e-3,
      .latency_max_us = static_cast<double>(end_ns - record.oldest_ns) * 1e-3,
      .stale = static_cast<std::int64_t>(record.stale),
      .overflow = static_cast<std::int64_t>(record.overflow),
  };
}

}  // namespace asap::inline v0_1
