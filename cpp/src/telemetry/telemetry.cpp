#include "telemetry/telemetry.hpp"

#include <thread>

namespace asap::inline v0_1 {

void Telemetry::reset(std::int64_t latency_bound_ns) noexcept {
  log.clear();
  latency.clear(latency_bound_ns);
  for (auto* count : {&filtered, &discarded, &stale, &overflow, &delivered}) *count = 0;
}

Ledger Telemetry::ledger() const noexcept {
  return {.filtered = filtered,
          .discarded = discarded,
          .stale = stale,
          .overflow = overflow,
          .delivered = delivered};
}

void Telemetry::copy_to(Ledger& to, LatencyHistogram& latencies,
                        PackageTotals& packages) const noexcept {
  Copy copy{to, latencies, packages};
  while (!try_make(copy)) {
    Copy* other = nullptr;
    const bool is_asked = asked_.compare_exchange_strong(other, &copy, std::memory_order_release,
                                                         std::memory_order_relaxed);
    std::this_thread::yield();
    Copy* mine = &copy;
    if (!is_asked || asked_.compare_exchange_strong(mine, nullptr, std::memory_order_relaxed)) {
      continue;  // the writer has not heard it
    }
    while (!copy.is_made.load(std::memory_order_acquire)) std::this_thread::yield();
    return;
  }
}

void Telemetry::make(Copy& copy) const noexcept {
  copy.ledger = ledger();
  copy.latency = latency;
  copy.packages = log.totals();
}

bool Telemetry::try_make(Copy& copy) const noexcept {
  const std::uint64_t before = steps_.load(std::memory_order_acquire);
  if (before % 2 != 0) return false;
  make(copy);
  fence(std::memory_order_acquire);
  return steps_.load(std::memory_order_relaxed) == before;
}

void Telemetry::answer() noexcept {
  Copy* const copy = asked_.exchange(nullptr, std::memory_order_acquire);
  if (copy == nullptr) return;  // withdrawn
  make(*copy);
  copy->is_made.store(true, std::memory_order_release);
}

}  // namespace asap::inline v0_1
