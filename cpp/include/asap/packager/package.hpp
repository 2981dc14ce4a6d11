// Package: the events of one call of the algorithm, and what it may want to know about them. On the
// consumer's thread, without allocation; the events stay valid until the package is completed.
//
//   const Consumer consumer = [&](const Package& package) {
//     tracker.set_gamma(package.gamma);
//     tracker.process(package.events);
//   };
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "asap/core/event.hpp"

namespace asap::inline v0_1 {

// events.size() / gamma is the number of events that thinning has seen since the package, or the
// part of one, before: those of packages and parts that kept nothing count to the next one. So the
// sum over all is what was received less stale, overflowed and filtered events, whatever the scheme
// and the execution. Each part of an anytime package has its own; raw, offered and filtered are
// those of the package so far, the events lost before are those of the package.
struct Package {
  EventSpan events;          // kept, oldest first; never empty when the algorithm sees it
  std::uint64_t index = 0;   // number of the package, from 0
  bool continues = false;    // a later part of an anytime package
  double gamma = 1.0;        // share of the events that thinning saw for these and kept: below
  std::size_t raw = 0;       // raw events that leave the ring when it is completed
  std::size_t offered = 0;   // raw events behind it: raw, and those of takes that kept nothing
  std::size_t filtered = 0;  // offered events that the front filter dropped
  std::uint64_t stale_before = 0;     // events lost as too old since the package before
  std::uint64_t overflow_before = 0;  // events lost to a full ring since the package before
  std::int64_t start_ns = 0;          // run time at which it was taken

  std::int64_t t_first() const noexcept { return events.front().t; }
  std::int64_t t_last() const noexcept { return events.back().t; }
  std::uint64_t lost_before() const noexcept { return stale_before + overflow_before; }

  // An algorithm may simply take events.
  operator EventSpan() const noexcept { return events; }
};

// The result of a wait: a package, none within the time, or none any more.
enum class Next { package, idle, ended };

// A filter in front of the gamma filter, such as BackgroundActivityFilter::process. It sees every
// raw event that is not stale, in order, writes those that pass to `out`, which holds at least
// events.size() and is other memory, and returns their number. Called on the consumer's thread; its
// time is part of the measured cost.
using FrontFilter = std::function<std::size_t(EventSpan events, std::span<Event> out)>;

// What became of the events of a recording (RunConfig::keep_mask).
struct KeptEvents {
  std::vector<std::uint8_t> kept;   // one byte per received event: 1 = delivered
  std::vector<std::int64_t> first;  // number of the first raw event, per package
};

}  // namespace asap::inline v0_1
