// A ring and a packager, with the books of what went in.
#pragma once

#include <cstddef>
#include <cstdint>

#include "asap/telemetry/ledger.hpp"
#include "packager/event_times.hpp"
#include "packager/packager.hpp"
#include "telemetry/telemetry.hpp"

namespace asap::test {

struct PackagerRig {
  static constexpr std::int64_t kBound_ns = 10'000'000;

  explicit PackagerRig(Scheme& scheme, std::size_t capacity, PackagerConfig config)
      : buffer(capacity), packager(buffer, ages, scheme, telemetry, config) {
    packager.begin(TimeAxis(0, 1.0), 0);
  }

  void push(EventSpan events) {
    received += events.size();
    const std::uint64_t first = buffer.tail();
    const std::size_t taken = buffer.push(events);
    ages.observe(events.first(taken), first, [](std::int64_t stamp) { return 1000 * stamp; });
  }

  Packager::Next next(std::int64_t now_ns) {
    telemetry.log.make_room();
    return packager.next(now_ns);
  }

  Ledger ledger() const {
    return {.received = received,
            .filtered = telemetry.filtered,
            .discarded = telemetry.discarded,
            .stale = telemetry.stale,
            .overflow = buffer.overflow(),
            .delivered = telemetry.delivered,
            .pending = buffer.size()};
  }

  EventBuffer buffer;
  AgeSlots ages{kBound_ns / 64};
  Telemetry telemetry{kBound_ns};
  Packager packager;
  std::uint64_t received = 0;
};

}  // namespace asap::test
