#include "formats/aedat_header.hpp"

#include <gtest/gtest.h>

namespace asap::aedat_header_test {
namespace {

TEST(AedatSensor, IsFoundInNamesOfManyKinds) {
  const AedatSensor sensor = aedat_sensor(" eu.seebetter.ini.chips.davis.Davis346blue\r\n");
  EXPECT_TRUE(sensor.is_davis);
  EXPECT_FALSE(sensor.is_dvs128);
  EXPECT_EQ(sensor.width, 346);
  EXPECT_EQ(sensor.height, 260);
  EXPECT_EQ(aedat_sensor("DAVISRGBW640").height, 480);
  EXPECT_TRUE(aedat_sensor("ch.unizh.ini.jaer.chip.retina.DVS128").is_dvs128);
  EXPECT_EQ(aedat_sensor("DAVIS FX2").width, 0);
  EXPECT_FALSE(aedat_sensor("").is_davis);
}

TEST(AedatLine, EndsAtTheNewline) {
  EXPECT_EQ(aedat_line("# a\tb\r\n# c"), "# a\tb\r\n");
  EXPECT_EQ(aedat_line("#\xc3\xa9\n"), "#\xc3\xa9\n");
}

TEST(AedatLine, IsEmptyWhereThereIsNone) {
  EXPECT_EQ(aedat_line("x\n"), "");
  EXPECT_EQ(aedat_line(std::string_view("#\0\n", 3)), "");
}

TEST(AedatLine, IsNothingWithoutItsEnd) {
  EXPECT_FALSE(aedat_line(""));
  EXPECT_FALSE(aedat_line("# a"));
}

}  // namespace
}  // namespace asap::aedat_header_test
