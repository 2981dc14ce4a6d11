#include "asap/runner/system.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

namespace asap {
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
  std::thread sleeper([&] {
    while (word == 1) System::sleep(word, System::now() + 1h);
  });
  word = 0;
  System::wake(word);
  sleeper.join();
}

}  // namespace
}  // namespace asap
