// Doorbell: lets the consumer sleep until the ring has what it waits for. The consumer announces
// that it sleeps and for which tail; only then does the producer make one system call. Otherwise
// the producer's part is one atomic operation: wait-free. No polling, no lock on the producer's
// side.
//
// Why no wake-up is lost: asleep_ is only ever written by read-modify-writes, on both sides. If the
// producer's comes first in its modification order, the consumer's synchronises with it and then
// sees the tail that was stored before it; otherwise the producer sees that the consumer sleeps.
#pragma once

#include <atomic>
#include <cstdint>

#include "asap/core/nonblocking.hpp"
#include "core/atomics.hpp"
#include "runner/system.hpp"

namespace asap::inline v0_1 {

template <class Atomics = StdAtomics, class Sleep = System>
class BasicDoorbell {
 public:
  using Clock = System::Clock;

  // Producer, after every push: the ring's tail is now `tail`. noexcept, wait-free while the
  // consumer is awake.
  void announce(std::uint64_t tail) noexcept {
    if (asleep_.fetch_or(0, std::memory_order_acq_rel) == 0) return;
    if (static_cast<std::int64_t>(tail - wanted_.load(std::memory_order_relaxed)) >= 0) wake();
  }

  // Any thread: the consumer shall look up, whatever it waits for.
  void wake() noexcept {
    if (asleep_.exchange(0, std::memory_order_acq_rel) == 0) return;
    exempt([&] { Sleep::wake(asleep_); });  // the one system call of the hot path
  }

  // Consumer. Sleeps until announce() has reached `wanted_tail`, until wake() or until the
  // deadline, whichever is first; may also return early. `ready` is asked once after the
  // announcement that the consumer sleeps: true = do not sleep.
  template <class Ready>
  void wait(std::uint64_t wanted_tail, Clock::time_point deadline, Ready&& ready) noexcept {
    wanted_.store(wanted_tail, std::memory_order_relaxed);
    asleep_.exchange(1, std::memory_order_acq_rel);
    if (!ready()) Sleep::sleep(asleep_, deadline);
    asleep_.exchange(0, std::memory_order_acq_rel);
  }

 private:
  template <class Value>
  using Atomic = typename Atomics::template Atomic<Value>;

  alignas(128) Atomic<std::uint32_t> asleep_{0};  // 1 while the consumer sleeps
  Atomic<std::uint64_t> wanted_{0};
};

using Doorbell = BasicDoorbell<>;

}  // namespace asap::inline v0_1
