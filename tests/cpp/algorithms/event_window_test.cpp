#include "algorithms/event_window.hpp"

#include <gtest/gtest.h>

#include <set>

namespace event_window_test {
namespace {

using asap::Event;
using asap::EventWindow;

std::set<EventWindow::Position> chain(const EventWindow& window, EventWindow::Position member) {
  std::set<EventWindow::Position> positions;
  window.for_each(member,
                  [&](EventWindow::Position p) { EXPECT_TRUE(positions.insert(p).second); });
  return positions;
}

TEST(EventWindow, KeepsTheEvent) {
  EventWindow window(4);
  const auto position = window.append({.x = 3, .y = 5, .p = 1, .t = 7}, 11, 13);
  EXPECT_EQ(window[position].x, 3);
  EXPECT_EQ(window[position].y, 5);
  EXPECT_EQ(window[position].t, 7);
  EXPECT_EQ(window[position].cell, 11);
  EXPECT_EQ(window[position].cluster, 13);
}

TEST(EventWindow, OldestStandsWhereTheNextGoes) {
  EventWindow window(3);
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(window.full(), i >= 3);
    if (window.full()) {
      EXPECT_EQ(window[window.cursor()].t, i - 3);
    }
    window.append({.x = 0, .y = 0, .p = 0, .t = i}, 0, 0);
    EXPECT_EQ(window.oldest_t(), i < 3 ? 0 : i - 2);
    EXPECT_EQ(window.newest_t(), i);
  }
}

TEST(EventWindow, CapacityOfOne) {
  EventWindow window(1);
  for (int i = 0; i < 3; ++i) {
    const auto position = window.append({.x = 0, .y = 0, .p = 0, .t = i}, 0, 0);
    EXPECT_EQ(position, 0);
    EXPECT_EQ(window.cursor(), 0);
    EXPECT_TRUE(window.full());
    EXPECT_EQ(window.oldest_t(), i);
  }
}

TEST(EventWindow, ChainsJoinAndLoseEvents) {
  EventWindow window(8);
  for (int i = 0; i < 6; ++i) window.append({.x = 0, .y = 0, .p = 0, .t = i}, 0, 0);
  EXPECT_EQ(chain(window, 4), (std::set<EventWindow::Position>{4}));
  window.join(1, 0);
  window.join(2, 0);
  window.join(3, 5);
  EXPECT_EQ(chain(window, 0), (std::set<EventWindow::Position>{0, 1, 2}));
  EXPECT_EQ(chain(window, 5), (std::set<EventWindow::Position>{3, 5}));
  window.join(5, 1);
  EXPECT_EQ(chain(window, 3), (std::set<EventWindow::Position>{0, 1, 2, 3, 5}));
  std::set<EventWindow::Position> rest{0, 1, 2, 3, 5};
  while (rest.size() > 1) {  // neighbours leave one after the other
    const EventWindow::Position leaving = window[*rest.rbegin()].next;
    window.unchain(leaving);
    rest.erase(leaving);
    EXPECT_EQ(chain(window, *rest.begin()), rest);
  }
  EXPECT_EQ(chain(window, 4), (std::set<EventWindow::Position>{4}));
}

TEST(EventWindow, ClearStartsAgain) {
  EventWindow window(2);
  for (int i = 0; i < 3; ++i) window.append({.x = 0, .y = 0, .p = 0, .t = i}, 0, 0);
  window.clear();
  EXPECT_FALSE(window.full());
  EXPECT_EQ(window.cursor(), 0);
}

}  // namespace
}  // namespace event_window_test
