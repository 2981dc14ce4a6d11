// Event: one brightness change of one pixel; plain data, no allocation. 16 bytes, byte-identical to
// Metavision's EventCD, so such arrays enter without a copy. Two bytes between p and t are padding:
// compare and hash fields. EventSource: where a run gets its events from, on one thread.
//
//   const Event event{.x = 3, .y = 4, .p = 1, .t = 1'000};  // px, px, ON, us
#pragma once

#if __cplusplus < 201709L  // as gcc 10 calls C++20
#error \
    "asap needs C++20: compile with -std=c++20, or link the CMake target asap::core, which asks for it"
#endif

#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <utility>

namespace asap::inline v0_1 {

struct Event {
  std::uint16_t x;  // px, to the right
  std::uint16_t y;  // px, downwards; (0, 0) is top left
  std::int16_t p;   // polarity: 1 = ON, 0 = OFF
  std::int64_t t;   // us of the sensor's clock

  friend bool operator==(const Event&, const Event&) = default;
};

using EventSpan = std::span<const Event>;

static_assert(
    sizeof(std::size_t) == 8,
    "asap needs a 64-bit target: it counts events in std::size_t; use aarch64, not armhf");
static_assert(sizeof(Event) == 16 && offsetof(Event, x) == 0 && offsetof(Event, y) == 2 &&
              offsetof(Event, p) == 4 && offsetof(Event, t) == 8);
static_assert(std::is_trivially_copyable_v<Event> && std::is_standard_layout_v<Event>);

// A recording, a scene, memory, or your own. One thread reads: in a replay its producer.
class EventSource {
 public:
  virtual ~EventSource() = default;

  // Returns the next chunk, valid until the next call; an empty one at the end. May block.
  [[nodiscard]] virtual EventSpan next() = 0;
  // Any thread. Makes a next() that blocks return the end, and all later calls too.
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

}  // namespace asap::inline v0_1
