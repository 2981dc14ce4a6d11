// EventStream: a seeded stream of synthetic events, made block by block as it is read. Times never
// go back, memory is allocated in the constructor alone, and the same configuration gives the same
// events on every compiler: streams decide with integers, + - * / and sqrt only, compiled with
// -ffp-contract=off, hence in .cpp files. Any one thread reads; one virtual call per block.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "asap/core/event.hpp"

namespace asap {

class EventStream {
 public:
  virtual ~EventStream() = default;

  // The next block, valid until the next call. Empty when, and only when, the stream has ended.
  [[nodiscard]] virtual EventSpan next() noexcept = 0;
};

// Reads whole blocks until there are `at_least` events or the stream has ended; empty at the end.
inline std::vector<Event> read_events(EventStream& stream, std::size_t at_least) {
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
