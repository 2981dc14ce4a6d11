#include "runner/consumer_loop.hpp"

#include <algorithm>

namespace asap::inline v0_1 {
namespace {

std::int64_t ns(RunClock::Steady::time_point time) noexcept {
  return std::chrono::nanoseconds(time.time_since_epoch()).count();
}

// A patience may be for ever.
RunClock::Steady::time_point later(RunClock::Steady::time_point now,
                                   std::chrono::nanoseconds patience) noexcept {
  constexpr auto kEnd = RunClock::Steady::time_point::max();
  return patience < kEnd - now ? now + patience : kEnd;
}

}  // namespace

ConsumerLoop::Next ConsumerLoop::next(Package& package, std::chrono::nanoseconds patience,
                                      const Poll& poll) {
  for (; poll && patience > kPollEvery; patience -= kPollEvery) {
    if (const Next next = wait(package, kPollEvery); next != Next::idle) return next;
    poll();
  }
  return wait(package, patience);
}

ConsumerLoop::Next ConsumerLoop::wait(Package& package, std::chrono::nanoseconds patience) {
  telemetry_.log.make_room();
  const auto entered = System::now();
  watch_.on_wake(ns(entered), telemetry_.latency.bound_ns());
  const auto deadline = later(entered, patience);
  for (;;) {
    const Asked now = asked();
    if (now.abandoned) return Next::ended;
    heed(now);
    Packager::Next next{.until_tail = buffer_.head() + 1};
    if (const std::uint64_t seen = buffer_.tail(); seen != buffer_.head()) {
      next = packager_.next(clock_.now_ns(), seen);  // the clock runs once an event is there
      if (next.step == Packager::Step::package) {
        package = next.package;
        watch_.on_work();
        return Next::package;
      }
      if (next.step == Packager::Step::ended) return Next::ended;  // nothing of the rest was kept
    } else if (now.closed) {
      return Next::ended;
    }
    if (System::now() >= deadline) return Next::idle;

    if (room_ != nullptr) room_->announce(buffer_.head());
    watch_.on_sleep();
    doorbell_.wait(next.until_tail, std::min(deadline, clock_.when(next.until_ns)),
                   [&] { return buffer_.tail() >= next.until_tail || asked() != now; });
    watch_.on_wake(ns(System::now()), telemetry_.latency.bound_ns());
  }
}

ConsumerLoop::Asked ConsumerLoop::asked() const noexcept {
  return {.closed = buffer_.closed(),
          .abandoned = abandoned_.load(std::memory_order_acquire),
          .flush = flush_.load(std::memory_order_acquire),
          .bound_ns = bound_ns_.load(std::memory_order_acquire)};
}

void ConsumerLoop::heed(const Asked& asked) noexcept {
  packager_.flush(asked.flush);
  if (asked.bound_ns != 0 && asked.bound_ns != telemetry_.latency.bound_ns()) {
    packager_.set_latency_bound(asked.bound_ns);
  }
  if (room_ != nullptr) room_->announce(buffer_.head());
}

void ConsumerLoop::set_latency_bound(std::int64_t bound_ns) noexcept {
  bound_ns_.store(bound_ns, std::memory_order_release);
  doorbell_.wake();
}

bool ConsumerLoop::stalled(std::size_t waiting) const noexcept {
  return waiting > 0 && watch_.stalled(ns(System::now()), telemetry_.latency.bound_ns());
}

void ConsumerLoop::begin() noexcept { watch_.on_begin(ns(System::now())); }

void ConsumerLoop::flush() noexcept {
  const std::uint64_t tail = buffer_.tail();
  std::uint64_t due = flush_.load(std::memory_order_relaxed);
  // Never back: the producer may flush too.
  while (due < tail && !flush_.compare_exchange_weak(due, tail, std::memory_order_release)) {
  }
  doorbell_.wake();
}

void ConsumerLoop::abandon() noexcept {
  abandoned_.store(true, std::memory_order_release);
  doorbell_.wake();
}

void ConsumerLoop::work(Package package, const Consumer& algorithm) {
  std::int64_t now_ns = package.start_ns;
  for (EventSpan events = packager_.stratum(package, now_ns); !events.empty();
       events = packager_.stratum(package, now_ns)) {
    Package part = package;
    part.events = events;
    algorithm(part);
    package.continues = true;
    now_ns = clock_.now_ns();
  }
  packager_.complete(package, now_ns);
}

void ConsumerLoop::run(const Consumer& algorithm, const Poll& poll) {
  Package package;
  std::int64_t polled_ns = kLongAgo;
  while (next(package, std::chrono::nanoseconds::max(), poll) != Next::ended) {
    work(package, algorithm);
    if (polled_ns != kLongAgo && package.start_ns - polled_ns < kPollEvery.count()) continue;
    polled_ns = package.start_ns;
    if (poll) poll();
  }
}

}  // namespace asap::inline v0_1
