#include "runner/intake.hpp"

#include <algorithm>
#include <chrono>

#include "asap/core/nonblocking.hpp"

namespace asap::inline v0_1 {
namespace {

// The number of waiting events up to which nothing is thinned.
std::size_t thinning_begins(std::size_t capacity) noexcept { return capacity - capacity / 4; }

// How many of a push the law lets in.
double admitted(std::size_t events, std::size_t room, std::size_t capacity) noexcept {
  const double reserve = 0.25 * static_cast<double>(capacity);
  const double before = std::max(static_cast<double>(room) - reserve, 0.0);
  const double whole = std::min(static_cast<double>(events), before);
  const double thinned = static_cast<double>(events) - whole;
  const double left = std::min(static_cast<double>(room), reserve);
  return whole + left * left * thinned / (reserve * reserve + left * thinned);
}

}  // namespace

void Intake::take(EventSpan events, std::int64_t arrival_ns, const Poll& poll) {
  if (when_full_ == WhenFull::block) return put_waiting(events, arrival_ns, poll);
  take(events, arrival_ns);
}

void Intake::take(EventSpan events, std::int64_t arrival_ns) noexcept {
  if (when_full_ == WhenFull::block) {
    return exempt([&] { put_waiting(events, arrival_ns, {}); });  // as the user has asked for
  }
  if (when_full_ == WhenFull::thin) {
    const std::size_t max = thinning_begins(buffer_.capacity());
    if (events.size() > max || buffer_.filled(max - events.size()) > max - events.size()) {
      return thin(events, arrival_ns);
    }
  }
  filter_.skip(events.size());
  put(events, arrival_ns);
}

void Intake::put_waiting(EventSpan events, std::int64_t arrival_ns, const Poll& poll) {
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

void Intake::put(EventSpan events, std::int64_t arrival_ns) noexcept {
  const std::size_t taken = enter(events, arrival_ns);
  gap_.kept(events.first(taken));
  if (taken < events.size()) gap_.lost(events.subspan(taken));
}

// Returns how many there was room for.
std::size_t Intake::enter(EventSpan events, std::int64_t arrival_ns) noexcept {
  arrivals_.note(buffer_.tail(), arrival_ns, discarded_);
  const std::size_t taken = buffer_.push(events);
  max_waiting_ = std::max<std::uint64_t>(max_waiting_, buffer_.filled(max_waiting_));
  return taken;
}

void Intake::thin(EventSpan events, std::int64_t arrival_ns) noexcept {
  std::size_t room = buffer_.capacity() - buffer_.filled(0);
  if (room == 0) {
    filter_.skip(events.size());
    put(events, arrival_ns);
    return;
  }
  double wanted = admitted(events.size(), room, buffer_.capacity());
  while (!events.empty()) {
    const EventSpan block = events.first(std::min(events.size(), kBlock));
    const double share = wanted / static_cast<double>(events.size());
    const std::size_t kept = filter_.apply(block, bar(share, block.size(), room), scratch_);
    discarded_ += block.size() - kept;
    gap_.thinned(block, {scratch_.data(), enter({scratch_.data(), kept}, arrival_ns)});
    wanted -= static_cast<double>(kept);
    events = events.subspan(block.size());
    room = buffer_.capacity() - buffer_.filled(0);
  }
}

// By chance, but never more than there is room for.
KeepThreshold Intake::bar(double share, std::size_t events, std::size_t room) noexcept {
  const KeepThreshold chance = KeepThreshold::clamped(share);
  if (events <= room) return chance;
  const KeepThreshold max = filter_.keeping(room, events, numbers_);
  return chance.value() < max.value() ? chance : max;
}

void Intake::wait_for_room(std::size_t wanted, const Poll& poll) {
  announce();
  const std::uint64_t wanted_head = buffer_.tail() + wanted - buffer_.capacity();
  room_.wait(wanted_head, System::now() + kPollEvery, [&] {
    return static_cast<std::int64_t>(buffer_.head() - wanted_head) >= 0 ||
           left_.load(std::memory_order_acquire);
  });
  if (poll) poll();
}

void Intake::leave() noexcept {
  left_.store(true, std::memory_order_release);
  room_.wake();
}

}  // namespace asap::inline v0_1
