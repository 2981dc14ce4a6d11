// EventSource: where a run gets its events from: a recording, a scene, memory, or your own.
#pragma once

#include <utility>

#include "asap/core/event.hpp"

namespace asap {

// One thread reads: in a replay its producer.
class EventSource {
 public:
  virtual ~EventSource() = default;

  // The next chunk, valid until the call after; empty = the end. May block.
  [[nodiscard]] virtual EventSpan next() = 0;
  // Any thread: a next() that blocks returns the end, and so do all later ones.
  virtual void cancel() noexcept {}
};

// Events that lie in memory.
class SpanSource final : public EventSource {
 public:
  explicit SpanSource(EventSpan events) noexcept : events_(events) {}

  [[nodiscard]] EventSpan next() override { return std::exchange(events_, {}); }

 private:
  EventSpan events_;
};

}  // namespace asap
