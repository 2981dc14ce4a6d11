#include "runner/system.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

namespace asap::system_test {
namespace {

using namespace std::chrono_literals;

TEST(System, NowIsTheSteadyClock) {
  const auto before = System::Clock::now();
  const auto now = System::now();
  EXPECT_LE(before, now);
  EXPECT_LE(now, System::Clock::now());
}

TEST(System, DoesNotSleepOnAWordThatIsNoLongerOne) {
  System::Word word{0};
  System::sleep(word, System::now() + 1h);
}

TEST(System, DoesNotSleepBehindItsDeadline) {
  System::Word word{1};
  System::sleep(word, System::now() - 1ns);
  EXPECT_EQ(word, 1u);
}

TEST(System, WakesWhoSleeps) {
  System::Word word{1};
  std::atomic<bool> woken = false;
  std::thread sleeper([&] {
    while (word == 1) System::sleep(word, System::now() + 10s);
    woken = true;
  });
  std::this_thread::sleep_for(50ms);  // it sleeps by now
  word = 0;
  System::wake(word);
  for (int i = 0; i < 500 && !woken; ++i) std::this_thread::sleep_for(10ms);
  EXPECT_TRUE(woken) << "only the deadline would wake it";
  sleeper.join();
}

}  // namespace
}  // namespace asap::system_test
