#include "asap/runner/consumer_loop.hpp"

#include <algorithm>

namespace asap {

ConsumerLoop::Next ConsumerLoop::next(Package& package, std::chrono::nanoseconds patience) {
  telemetry_.log.make_room();
  const auto deadline = RunClock::Steady::now() + patience;
  for (;;) {
    const Asked now = asked();
    if (now.abandoned) return Next::ended;
    packager_.flush(now.flush);
    Packager::Next next{.until_tail = buffer_.head() + 1};
    if (buffer_.size() > 0) {  // the clock runs once an event is there
      next = packager_.next(clock_.now_ns());
      if (next.step == Packager::Step::package) {
        package = next.package;
        return Next::package;
      }
    } else if (now.closed) {
      return Next::ended;
    }
    if (RunClock::Steady::now() >= deadline) return Next::idle;

    doorbell_.wait(next.until_tail, std::min(deadline, clock_.when(next.until_ns)),
                   [&] { return buffer_.tail() >= next.until_tail || asked() != now; });
  }
}

ConsumerLoop::Asked ConsumerLoop::asked() const noexcept {
  return {.closed = buffer_.closed(),
          .abandoned = abandoned_.load(std::memory_order_acquire),
          .flush = flush_.load(std::memory_order_acquire)};
}

void ConsumerLoop::flush() noexcept {
  flush_.store(buffer_.tail(), std::memory_order_release);
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

}  // namespace asap
