#include "runner/system.hpp"

namespace asap::inline v0_1 {

System::Clock::time_point System::now() noexcept {
  return exempt([] { return Clock::now(); });  // without a system call on Linux
}

}  // namespace asap::inline v0_1

#if defined(__linux__)

#include <linux/futex.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <ctime>

namespace asap::inline v0_1 {
namespace {

static_assert(sizeof(System::Word) == sizeof(std::uint32_t) && System::Word::is_always_lock_free);

}  // namespace

void System::wake(Word& word) noexcept {
  syscall(SYS_futex, &word, FUTEX_WAKE_PRIVATE, 1, nullptr, nullptr, 0);
}

void System::sleep(Word& word, Clock::time_point deadline) noexcept {
  using std::chrono::duration_cast;
  const auto since = deadline.time_since_epoch();
  const auto seconds = duration_cast<std::chrono::seconds>(since);
  timespec until{};  // steady_clock is CLOCK_MONOTONIC here, and so is this wait
  until.tv_sec = static_cast<std::time_t>(seconds.count());
  until.tv_nsec =
      static_cast<long>(duration_cast<std::chrono::nanoseconds>(since - seconds).count());
  syscall(SYS_futex, &word, FUTEX_WAIT_BITSET_PRIVATE, 1, &until, nullptr, FUTEX_BITSET_MATCH_ANY);
}

}  // namespace asap::inline v0_1

#else

#include <condition_variable>
#include <mutex>

namespace asap::inline v0_1 {
namespace {

// One for all doorbells: the portable form wakes more than it must, but loses nothing.
std::mutex mutex;
std::condition_variable woken;

}  // namespace

void System::wake(Word&) noexcept {
  {
    const std::lock_guard lock(mutex);
  }
  woken.notify_all();
}

void System::sleep(Word& word, Clock::time_point deadline) noexcept {
  std::unique_lock lock(mutex);
  woken.wait_until(lock, deadline, [&] { return word.load(std::memory_order_acquire) != 1; });
}

}  // namespace asap::inline v0_1

#endif
