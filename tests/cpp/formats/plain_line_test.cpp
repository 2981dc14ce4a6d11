#include "formats/plain_line.hpp"

#include <gtest/gtest.h>

#include <string>

namespace asap::plain_line_test {
namespace {

std::size_t whole_txyp(std::string text, Event& event) {
  text.append(PlainLine::kRoom, '#');
  const char* const next = PlainLine::read_whole_txyp(text.data(), event);
  return next == nullptr ? 0 : static_cast<std::size_t>(next - text.data());
}

TEST(PlainLine, ReadsWholeNumbersWithOneSeparator) {
  Event event{};
  EXPECT_EQ(whole_txyp("1633953690975950,1279,719,1\n", event), 28u);
  EXPECT_EQ(event, (Event{.x = 1279, .y = 719, .p = 1, .t = 1'633'953'690'975'950}));
  EXPECT_EQ(whole_txyp("7 0 0012 0\n1 2 3", event), 11u);
  EXPECT_EQ(event, (Event{.x = 0, .y = 12, .p = 0, .t = 7}));
  EXPECT_EQ(whole_txyp("1234567890123456\t1234\t12345678\t1\n", event), 0u);
  EXPECT_EQ(whole_txyp("1234567890123456;1234;00123;1\n", event), 0u);
  EXPECT_EQ(whole_txyp("1234567890123456;001234;0123;1\n", event), 0u);
  EXPECT_EQ(whole_txyp("1234567890123456;1234;1234;5678\n", event), 0u);
}

TEST(PlainLine, LeavesOtherLinesThanThese) {
  Event event{};
  for (const char* text : {"1,2,3\n",
                           "1,2,3,1,5\n",
                           "1,2,3,10\n",
                           "1,2,3,\n",
                           "1,2,,1\n",
                           "1,,3,1\n",
                           ",2,3,1\n",
                           "1,2,3 1\n",
                           "1 2,3,1\n",
                           "1,2 3,1\n",
                           "1x2x3x1\n",
                           "1,2,3,-1\n",
                           "-1,2,3,1\n",
                           "1,2,3,1",
                           "1.5,2,3,1\n",
                           "1,2,3,1\r\n",
                           "1,12345,3,1\n",
                           "1,2,12345,1\n",
                           "12345678901234567,2,3,1\n",
                           " 1,2,3,1\n",
                           "1,2,3,1 \n",
                           "1, 2,3,1\n",
                           "",
                           "\n",
                           "x"}) {
    EXPECT_EQ(whole_txyp(text, event), 0u) << text;
  }
}

}  // namespace
}  // namespace asap::plain_line_test
