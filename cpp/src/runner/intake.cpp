#include "asap/runner/intake.hpp"

#include <algorithm>
#include <chrono>

namespace asap {
namespace {

constexpr auto kPollEvery = std::chrono::milliseconds(20);

// Of a ring's capacity; below it nothing is thinned.
std::size_t thinning_begins(std::size_t capacity) noexcept { return capacity - capacity / 4; }

}  // namespace

void Intake::take(EventSpan events, std::int64_t arrival_ns, const Poll& poll) {
  const std::size_t enough = thinning_begins(buffer_.capacity());
  if (when_full_ == WhenFull::thin && buffer_.filled(enough) > enough) {
    return thin(events, arrival_ns);
  }
  if (when_full_ != WhenFull::block) {
    filter_.skip(events.size());
    put(events, arrival_ns);
    return;
  }
  struct Overflow {
    Intake& intake;
    EventSpan& events;
    std::int64_t arrival_ns;
    ~Overflow() {
      if (!events.empty()) intake.put(events, arrival_ns);
    }
  } rest{*this, events, arrival_ns};
  while (!events.empty() && !left_.load(std::memory_order_acquire)) {
    const std::size_t room = buffer_.capacity() - buffer_.filled(0);
    const std::size_t count = std::min(events.size(), room);
    if (count == 0) {
      wait_for_room(std::min(events.size(), (buffer_.capacity() + 1) / 2), poll);
      continue;
    }
    put(events.first(count), arrival_ns);
    events = events.subspan(count);
  }
}

std::size_t Intake::put(EventSpan events, std::int64_t arrival_ns) noexcept {
  arrivals_.note(buffer_.tail(), arrival_ns, discarded_);
  const std::size_t taken = buffer_.push(events);
  doorbell_.announce(buffer_.tail());
  return taken;
}

void Intake::thin(EventSpan events, std::int64_t arrival_ns) noexcept {
  const std::size_t capacity = buffer_.capacity();
  const double most = 4.0 / static_cast<double>(capacity);
  while (!events.empty()) {
    const EventSpan block = events.first(std::min(events.size(), kBlock));
    const std::size_t room = capacity - buffer_.filled(0);
    const auto bar = room > 0 ? KeepThreshold::clamped(most * static_cast<double>(room))
                              : KeepThreshold::all();  // let it overflow: nobody empties the ring
    const std::size_t kept = filter_.apply(block, bar, scratch_.data());
    discarded_ += block.size() - kept;
    put({scratch_.data(), kept}, arrival_ns);
    events = events.subspan(block.size());
  }
}

void Intake::wait_for_room(std::size_t wanted, const Poll& poll) {
  const std::uint64_t wanted_head = buffer_.tail() + wanted - buffer_.capacity();
  room_.wait(wanted_head, Doorbell::Clock::now() + kPollEvery, [&] {
    return static_cast<std::int64_t>(buffer_.head() - wanted_head) >= 0 ||
           left_.load(std::memory_order_acquire);
  });
  if (poll) poll();
}

void Intake::leave() noexcept {
  left_.store(true, std::memory_order_release);
  room_.wake();
}

}  // namespace asap
