#include "asap/synthetic/event_stream.hpp"

#include <algorithm>

namespace asap {

std::vector<Event> read_events(EventStream& stream, std::size_t at_least) {
  std::vector<Event> events;
  events.reserve(std::min<std::size_t>(at_least, 1 << 20) * 5 / 4);  // with the last block's excess
  while (events.size() < at_least) {
    const EventSpan block = stream.next();
    if (block.empty()) break;
    events.insert(events.end(), block.begin(), block.end());
  }
  return events;
}

}  // namespace asap
