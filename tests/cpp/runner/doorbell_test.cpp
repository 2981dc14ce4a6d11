#include "runner/doorbell.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <thread>

namespace asap::doorbell_test {
namespace {

using Clock = Doorbell::Clock;
using namespace std::chrono_literals;

constexpr auto kForever = 120s;  // a test that comes to here has lost a wake-up

const auto kNotReady = [] { return false; };

// Runs `ring` again and again while another thread sleeps for a tail; true: it was woken by it.
template <class Ring>
bool wakes_within(Clock::duration patience, std::uint64_t wanted_tail, Ring&& ring) {
  Doorbell doorbell;
  std::atomic<bool> awake{false};
  const auto begin = Clock::now();
  std::thread sleeper([&] {
    doorbell.wait(wanted_tail, begin + kForever, kNotReady);
    awake = true;
  });
  while (!awake && Clock::now() < begin + patience) {
    ring(doorbell);
    std::this_thread::sleep_for(1ms);
  }
  const bool woken = awake;
  while (!awake) {
    doorbell.wake();
    std::this_thread::sleep_for(1ms);
  }
  sleeper.join();
  return woken;
}

// However late the sleeper has its turn.
template <class Ring>
bool wakes(std::uint64_t wanted_tail, Ring&& ring) {
  return wakes_within(kForever / 2, wanted_tail, ring);
}

template <class Ring>
bool lets_sleep(std::uint64_t wanted_tail, Ring&& ring) {
  return !wakes_within(200ms, wanted_tail, ring);
}

TEST(Doorbell, IsRungByATailThatIsReached) {
  EXPECT_TRUE(wakes(5, [](Doorbell& doorbell) { doorbell.announce(5); }));
  EXPECT_TRUE(wakes(5, [](Doorbell& doorbell) { doorbell.announce(6); }));
}

TEST(Doorbell, IsNotRungByATailThatIsTooLow) {
  EXPECT_TRUE(lets_sleep(5, [](Doorbell& doorbell) { doorbell.announce(4); }));
}

TEST(Doorbell, ATailBehindTheWrapIsAhead) {
  EXPECT_TRUE(wakes(~std::uint64_t{0}, [](Doorbell& doorbell) { doorbell.announce(3); }));
  EXPECT_TRUE(lets_sleep(3, [](Doorbell& doorbell) { doorbell.announce(~std::uint64_t{0}); }));
}

TEST(Doorbell, IsRungByWake) {
  EXPECT_TRUE(wakes(5, [](Doorbell& doorbell) { doorbell.wake(); }));
}

TEST(Doorbell, LetsGoAtTheDeadline) {
  Doorbell doorbell;
  doorbell.wait(5, Clock::now() + 20ms, kNotReady);
  doorbell.wait(5, Clock::now() - 20ms, kNotReady);
  doorbell.wait(5, Clock::time_point{}, kNotReady);
}

TEST(Doorbell, DoesNotSleepWhenReady) {
  Doorbell doorbell;
  int asked = 0;
  doorbell.wait(5, Clock::time_point::max(), [&] {
    ++asked;
    return true;
  });
  EXPECT_EQ(asked, 1);
}

TEST(Doorbell, NobodyAsleepIsFine) {
  Doorbell doorbell;
  doorbell.announce(1);
  doorbell.wake();
}

// Two threads, each waiting for the other. A lost wake-up ends at the deadline, and is counted.
TEST(Doorbell, LosesNoWakeUpInAHundredThousandRounds) {
  constexpr std::uint64_t kRounds = 100'000;
  struct Side {
    Doorbell doorbell;
    std::atomic<std::uint64_t> tail{0};
  };
  Side ping;
  Side pong;
  std::atomic<int> lost{0};
  const auto wait_for = [&](Side& side, std::uint64_t tail) {
    while (side.tail.load(std::memory_order_acquire) < tail && lost == 0) {
      const auto deadline = Clock::now() + kForever;
      side.doorbell.wait(tail, deadline, [&] {
        const bool ready = side.tail.load(std::memory_order_acquire) >= tail;
        if (tail % 4 == 0) std::this_thread::yield();  // the other side rings right here
        return ready;
      });
      if (Clock::now() >= deadline) ++lost;
    }
  };
  const auto announce = [](Side& side, std::uint64_t tail) {
    side.tail.store(tail, std::memory_order_release);
    side.doorbell.announce(tail);
  };
  std::thread other([&] {
    for (std::uint64_t i = 1; i <= kRounds; ++i) {
      wait_for(ping, i);
      announce(pong, i);
    }
  });
  for (std::uint64_t i = 1; i <= kRounds && lost == 0; ++i) {
    announce(ping, i);
    wait_for(pong, i);
  }
  announce(ping, kRounds);
  other.join();
  EXPECT_EQ(lost, 0);
}

}  // namespace
}  // namespace asap::doorbell_test
