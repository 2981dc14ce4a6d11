#include "asap/formats/prophesee.hpp"

#include <gtest/gtest.h>

#include <string>

namespace asap::raw_header_test {
namespace {

using Words = RawHeader::Words;

std::optional<RawHeader> read(const std::string& text) {
  return read_raw_header(std::as_bytes(std::span(text)));
}

TEST(RawHeader, OldKeys) {
  const std::string text =
      "% Date 2020-09-14 09:03:25\n% evt 2.0\n% plugin_name hal_plugin_gen3_fx3\n";
  const auto header = read(text + "\x01\x02");
  ASSERT_TRUE(header);
  EXPECT_EQ(header->size, text.size());
  EXPECT_EQ(header->words, Words::evt2);
  EXPECT_EQ(header->width, 640);
  EXPECT_EQ(header->height, 480);
}

TEST(RawHeader, NewKeysCountMore) {
  const auto header =
      read("% evt 2.0\n% format EVT3;height=720;width=1280\n% evt 2.1\n% end\n% evt 2.0\n");
  ASSERT_TRUE(header);
  EXPECT_EQ(header->words, Words::evt3);
  EXPECT_EQ(header->width, 1280);
  EXPECT_EQ(header->height, 720);
  EXPECT_EQ(header->size, 62u);
}

TEST(RawHeader, Endianness) {
  EXPECT_TRUE(read("% format EVT21;endianness=little;height=2;width=1\n")->little_endian);
  EXPECT_FALSE(read("% format EVT21;endianness=legacy\n")->little_endian);
  EXPECT_FALSE(read("% evt 2.1\n")->little_endian);
  EXPECT_TRUE(read("% evt 2.1\n% endianness little\n")->little_endian);
  EXPECT_EQ(read("% format EVT21;endianness=little\n")->words, Words::evt21);
}

TEST(RawHeader, GeometryBeatsThePluginAndAbsurdNumbersAreAbsent) {
  const auto header = read("% plugin_name hal_plugin_gen41_evk3\r\n% geometry 320x200\r\n");
  EXPECT_EQ(header->width, 320);
  EXPECT_EQ(header->height, 200);
  const auto absurd = read("% geometry 99999999999x-3\n% format EVT9;width=65536;height=0\n");
  EXPECT_EQ(absurd->width, 0);
  EXPECT_EQ(absurd->height, 0);
  EXPECT_EQ(absurd->words, Words::unknown);
  EXPECT_EQ(read("% geometry 65537x5\n")->width, 0);
  EXPECT_EQ(read("% geometry 5x-3\n")->height, 0);
  EXPECT_EQ(read("% plugin_name hal_plugin_imx636\n")->width, 1280);
}

TEST(RawHeader, Dat) {
  const auto header =
      read("% Data file containing CD events.\n% Version 2\n% Height 240\n% Width 304\n" +
           std::string("\x0c\x08", 2));
  EXPECT_TRUE(header->is_dat);
  EXPECT_EQ(header->version, 2);
  EXPECT_EQ(header->width, 304);
  EXPECT_EQ(header->height, 240);
  EXPECT_EQ(read("% Data file containing CD events.\n")->version, -1);
}

TEST(RawHeader, EndsBeforeWhatIsNoLineOfText) {
  EXPECT_EQ(read("% evt 2.0\n%\x01 2\n")->size, 10u);
  EXPECT_EQ(read("% evt 2.0\n% \x7f 2\n")->size, 10u);
  EXPECT_EQ(read("% evt 2.0\n% cut")->size, 10u);
  EXPECT_EQ(read("% evt 2.0\n% " + std::string(5000, 'a') + "\n")->size, 10u);
  EXPECT_FALSE(read(""));
  EXPECT_FALSE(read("%"));
  EXPECT_FALSE(read("0 1 2 3\n"));
  EXPECT_FALSE(read("%x\n"));
}

}  // namespace
}  // namespace asap::raw_header_test
