// FrontFilter: a filter in front of the gamma filter, as the packager calls it, such as
// BackgroundActivityFilter::process. It sees every raw event that is not stale, in order, writes
// those that pass to `out`, which holds at least events.size() and is other memory, and returns
// their number. On the consumer's thread; its time is part of the measured cost.
#pragma once

#include <cstddef>
#include <functional>

#include "asap/core/event.hpp"

namespace asap {

using FrontFilter = std::function<std::size_t(EventSpan events, Event* out)>;

}  // namespace asap
