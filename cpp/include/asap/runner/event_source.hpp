// EventSource: where a replay gets its chunks from. next() is called on the producer's thread.
#pragma once

#include "asap/core/event.hpp"

namespace asap {

class EventSource {
 public:
  virtual ~EventSource() = default;

  // The next chunk, valid until the call after; empty = the end. May block.
  virtual EventSpan next() = 0;
  // Any thread: a next() that blocks returns the end, and so do all later ones.
  virtual void cancel() noexcept {}
};

// Events that lie in memory.
class SpanSource final : public EventSource {
 public:
  explicit SpanSource(EventSpan events) noexcept : events_(events) {}

  EventSpan next() override {
    const EventSpan all = events_;
    events_ = {};
    return all;
  }

 private:
  EventSpan events_;
};

}  // namespace asap
