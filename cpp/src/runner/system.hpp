// System: all that a live run asks of the operating system: the time, to sleep until it is woken,
// and to wake. Any thread. It is a seam of the linker: system.cpp is on its own in the library, and
// a program that defines these three functions itself runs the very same pipeline on another
// machine, such as one of virtual time (tests/simulation). No pointer, no parameter, no cost.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>

#include "asap/core/nonblocking.hpp"

namespace asap::inline v0_1 {

// How often a thread that waits calls its poll, and sees that it is to stop.
inline constexpr std::chrono::nanoseconds kPollEvery = std::chrono::milliseconds(20);

struct System {
  using Clock = std::chrono::steady_clock;
  using Word = std::atomic<std::uint32_t>;

  // The wall clock is never looked at.
  static Clock::time_point now() noexcept ASAP_NONBLOCKING;
  // Sleeps while the word is 1, until wake() or the deadline; may return early.
  static void sleep(Word& word, Clock::time_point deadline) noexcept;
  // Wakes who sleeps there, once the word is no longer 1.
  static void wake(Word& word) noexcept;
};

}  // namespace asap::inline v0_1
