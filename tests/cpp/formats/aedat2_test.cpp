#include "asap/formats/aedat.hpp"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

#include "formats/decoding.hpp"

namespace asap::aedat2_test {
namespace {

using namespace decoding;

constexpr Aedat2Config kDavis346{.chip = Aedat2Chip::davis, .width = 346, .height = 260};
constexpr Aedat2Config kDvs128{.chip = Aedat2Chip::dvs128, .width = 128, .height = 128};

void append_record(Bytes& bytes, std::uint32_t address, std::uint32_t t) {
  append_big(bytes, address, 4);
  append_big(bytes, t, 4);
}

std::uint32_t davis(unsigned x, unsigned y, unsigned p) { return y << 22 | x << 12 | p << 11; }
std::uint32_t dvs128(unsigned x, unsigned y, unsigned off) { return y << 8 | x << 1 | off; }

TEST(Aedat2Decoder, TurnsTheAddressesOfADavis) {
  Bytes bytes;
  append_record(bytes, davis(0, 0, 1), 10);
  append_record(bytes, davis(345, 259, 0), 11);
  append_record(bytes, davis(345 - 7, 259 - 9, 0) | 0x3ff, 12);  // the ten lowest bits say nothing
  EXPECT_EQ(events_of(Aedat2Decoder(kDavis346), bytes),
            (Events{{345, 259, 1, 10}, {0, 0, 0, 11}, {7, 9, 0, 12}}));
}

TEST(Aedat2Decoder, DecodesOneOfSeveralCameras) {
  Bytes bytes;
  append_record(bytes, davis(345, 259, 1) | 2, 10);
  append_record(bytes, davis(344, 259, 1) | 3, 11);
  Aedat2Config config = kDavis346;
  config.camera_bits = 0xf;
  config.camera = 3;
  EXPECT_EQ(events_of(Aedat2Decoder(config), bytes), (Events{{1, 0, 1, 11}}));
}

TEST(Aedat2Decoder, TellsTheCamerasOfAStereoPairApart) {
  Bytes bytes;
  append_record(bytes, dvs128(127, 127, 0), 10);
  append_record(bytes, 0x8000 | dvs128(126, 127, 0), 11);
  Aedat2Config config = kDvs128;
  config.camera_bits = 0x8000;
  EXPECT_EQ(events_of(Aedat2Decoder(config), bytes), (Events{{0, 0, 1, 10}}));
  config.camera = 1;
  Aedat2Decoder right(config);
  Decoded decoded;
  feed(right, bytes, 4, decoded);
  EXPECT_EQ(decoded.events, (Events{{1, 0, 1, 11}}));
  EXPECT_EQ(right.triggers(), 0u);
}

TEST(Aedat2Decoder, TurnsTheAddressesOfADvs640) {
  Bytes bytes;
  append_record(bytes, 0, 10);
  append_record(bytes, 479 << 11 | 639 << 1 | 1, 11);
  append_record(bytes, 1 << 20, 12);
  const Aedat2Decoder decoder({.chip = Aedat2Chip::dvs640, .width = 640, .height = 480});
  EXPECT_EQ(events_of(decoder, bytes), (Events{{639, 479, 0, 10}, {0, 0, 1, 11}}));
}

TEST(Aedat2Decoder, TurnsTheAddressesOfADvs1280) {
  Bytes bytes;
  append_record(bytes, 719 << 12 | 1279 << 1 | 1, 11);
  append_record(bytes, 1 << 22, 12);
  const Aedat2Decoder decoder({.chip = Aedat2Chip::dvs1280, .width = 1280, .height = 720});
  EXPECT_EQ(events_of(decoder, bytes), (Events{{0, 0, 1, 11}}));
}

TEST(Aedat2Decoder, TurnsTheAddressesOfADvs128) {
  Bytes bytes;
  append_record(bytes, dvs128(0, 0, 0), 10);
  append_record(bytes, dvs128(127, 127, 1), 11);
  append_record(bytes, 0x8000, 12);
  append_record(bytes, 0x8000'0000, 13);
  Aedat2Decoder decoder(kDvs128);
  Decoded decoded;
  feed(decoder, bytes, 4, decoded);
  EXPECT_EQ(decoded.events, (Events{{127, 127, 1, 10}, {0, 0, 0, 11}}));
  EXPECT_EQ(decoder.triggers(), 2u);
}

TEST(Aedat2Decoder, SkipsFramesAndMotionAndCountsTriggers) {
  Bytes bytes;
  append_record(bytes, 0x8000'0000 | davis(1, 2, 0), 10);          // a sample of a frame
  append_record(bytes, 0x8000'0000 | davis(1, 2, 1) | 0x400, 11);  // of the motion sensor
  append_record(bytes, 0x400, 12);                                 // a trigger
  append_record(bytes, davis(1, 2, 1), 13);
  Aedat2Decoder decoder(kDavis346);
  Decoded decoded;
  feed(decoder, bytes, 4, decoded);
  EXPECT_EQ(decoded.events, (Events{{344, 257, 1, 13}}));
  EXPECT_EQ(decoded.triggers, (Triggers{{12, 0, 1}}));
  EXPECT_EQ(decoder.triggers(), 1u);
}

TEST(Aedat2Decoder, ATriggerWithoutRoomWaitsWhereItIsWanted) {
  Bytes bytes;
  append_record(bytes, davis(1, 2, 1), 11);
  append_record(bytes, 0x400, 12);
  Aedat2Decoder decoder(kDavis346);
  Events events(4);
  EXPECT_EQ(decoder.decode(bytes, events, {}), (Progress{.bytes = 8, .events = 1, .triggers = 0}));
  const auto rest = std::span(bytes).subspan(8);
  EXPECT_EQ(decoder.decode(rest.first(5), events, {}).bytes, 5u);
  EXPECT_EQ(decoder.decode(rest.subspan(5), events, {}).bytes, 0u);
  EXPECT_EQ(decoder.triggers(), 0u);
  EXPECT_EQ(decoder.decode(rest.subspan(5), std::span(events)).bytes, 3u);  // not wanted: counted
  EXPECT_EQ(decoder.triggers(), 1u);
}

TEST(Aedat2Decoder, FollowsTheClockThroughItsWrap) {
  Bytes bytes;
  const auto at = [&](std::uint32_t t) { append_record(bytes, davis(1, 2, 1), t); };
  at(0xffff'fff0), at(0xffff'ffe0), at(5), at(0x7000'0000), at(0xe000'0000), at(1);
  const auto wrap = std::int64_t{1} << 32;
  const Events events = events_of(Aedat2Decoder(kDavis346), bytes);
  const std::int64_t times[] = {wrap - 16,          wrap - 32,          wrap + 5,
                                wrap + 0x7000'0000, wrap + 0xe000'0000, 2 * wrap + 1};
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(events.at(i).t, times[i]) << i;
}

TEST(Aedat2Decoder, GoesOnAfterASilenceOfMoreThanHalfTheWrap) {
  constexpr std::uint32_t kMinute_us = 60'000'000;
  Bytes bytes;
  for (const std::uint32_t t : {5u, 36 * kMinute_us, 71 * kMinute_us}) {
    append_record(bytes, davis(1, 2, 1), t);
  }
  const Events events = events_of(Aedat2Decoder(kDavis346), bytes);
  EXPECT_EQ(events.at(1).t, 36 * std::int64_t{kMinute_us});
  EXPECT_EQ(events.at(2).t, 71 * std::int64_t{kMinute_us});
}

TEST(Aedat2Decoder, AddressesBeyondTheSensorStayBeyondIt) {
  Bytes bytes;
  append_record(bytes, davis(1023, 511, 1), 10);
  const Events events = events_of(Aedat2Decoder(kDavis346), bytes);
  EXPECT_GE(events.at(0).x, 346);
  EXPECT_GE(events.at(0).y, 260);
}

TEST(Aedat2Decoder, RefusesWhatNoSensorIs) {
  EXPECT_THROW(Aedat2Decoder({.chip = Aedat2Chip::unnamed}), std::invalid_argument);
  EXPECT_THROW(Aedat2Decoder({.width = 0}), std::invalid_argument);
  EXPECT_THROW(Aedat2Decoder({.width = 1025}), std::invalid_argument);
  EXPECT_THROW(Aedat2Decoder({.height = 513}), std::invalid_argument);
  EXPECT_THROW(Aedat2Decoder({.camera = 1}), std::invalid_argument);
  EXPECT_THROW(Aedat2Decoder({.camera_bits = 0xf, .camera = 16}), std::invalid_argument);
  EXPECT_THROW(Aedat2Decoder({.chip = Aedat2Chip::dvs128, .width = 129}), std::invalid_argument);
}

Bytes file(std::string_view lines, std::uint32_t first_address = davis(5, 6, 1)) {
  Bytes bytes;
  append(bytes, "#!AER-DAT2.0\r\n# This is a raw AE data file - do not edit\r\n");
  append(bytes, lines);
  append_record(bytes, first_address, 1000);
  append_record(bytes, first_address, 1001);
  return bytes;
}

TEST(Aedat2Header, NamesTheChip) {
  const auto chip = [](std::string_view name) {
    return *read_aedat2_header(file("# AEChip: " + std::string(name) + "\r\n"));
  };
  const Aedat2Header davis240 = chip("eu.seebetter.ini.chips.davis.DAVIS240C");
  EXPECT_EQ(davis240.chip, Aedat2Chip::davis);
  EXPECT_EQ(davis240.width, 240);
  EXPECT_EQ(davis240.height, 180);
  EXPECT_EQ(chip("eu.seebetter.ini.chips.davis.Davis346B").width, 346);
  const Aedat2Header dvs = chip("ch.unizh.ini.jaer.chip.retina.DVS128");
  EXPECT_EQ(dvs.chip, Aedat2Chip::dvs128);
  EXPECT_EQ(dvs.width, 128);
  EXPECT_EQ(dvs.camera_bits, 0u);
  EXPECT_EQ(chip("ch.unizh.ini.jaer.chip.stereopsis.DVS128StereoPair").camera_bits, 0x8000u);
  EXPECT_EQ(chip("ch.unizh.ini.jaer.chip.multicamera.MultiDVS128CameraChip").camera_bits,
            0xff00'0000u);
  EXPECT_EQ(chip("ch.unizh.ini.jaer.chip.multicamera.MultiDAVIS346BCameraChip").camera_bits, 0xfu);
  EXPECT_EQ(chip("ch.unizh.ini.jaer.chip.retina.DVS1280x720SD").chip, Aedat2Chip::dvs1280);
  const Aedat2Header dvxplorer = chip("ch.unizh.ini.jaer.chip.retina.DVXplorer");
  EXPECT_EQ(dvxplorer.chip, Aedat2Chip::davis);
  EXPECT_EQ(dvxplorer.width, 640);
  EXPECT_EQ(chip("com.sec.dvs.SecDvs640Gen2").chip, Aedat2Chip::other);
  EXPECT_EQ(chip("ch.unizh.ini.jaer.chip.cochlea.CochleaAMS1c").chip, Aedat2Chip::other);
}

TEST(Aedat2Header, TheClassOfTheChipIsBetterThanTheCamera) {
  const auto both = read_aedat2_header(
      file("# AEChip: a.DAVIS240C\r\n# HardwareInterface: DAVIS FX2 84010032\r\n"));
  EXPECT_EQ(both->width, 240);
  const auto camera = read_aedat2_header(file("# HardwareInterface: DAVIS FX2 84010032\r\n"));
  EXPECT_EQ(camera->chip, Aedat2Chip::davis);
  EXPECT_EQ(camera->width, 0);
}

TEST(Aedat2Header, WithoutANameTheAddressesTell) {
  const auto guessed = read_aedat2_header(file("", dvs128(5, 6, 1)));
  EXPECT_EQ(guessed->chip, Aedat2Chip::dvs128);
  EXPECT_EQ(guessed->width, 0);  // the first rows of another chip look alike
  EXPECT_EQ(read_aedat2_header(file("", davis(5, 6, 1)))->chip, Aedat2Chip::unnamed);
}

TEST(Aedat2Header, EndsWhereTheRecordsBegin) {
  const Bytes bytes = file("# AEChip: a.DAVIS240C\r\n#\ttabs \xc3\xa9\r\n");
  EXPECT_EQ(read_aedat2_header(bytes)->size, bytes.size() - 16);
  // A first record that begins with '#'
  const Bytes hash = file("# AEChip: a.DAVIS240C\r\n", 0x2331'3233);
  EXPECT_EQ(read_aedat2_header(hash)->size, hash.size() - 16);
  const Bytes marked = file("# AEChip: a.DAVIS240C\r\n#End Of ASCII Header\r\n", 0x2331'3233);
  EXPECT_EQ(read_aedat2_header(marked)->size, marked.size() - 16);
}

TEST(Aedat2Header, IsNothingWithinALineOrOfOtherFiles) {
  const Bytes bytes = file("# AEChip: a.DAVIS240C\r\n");
  EXPECT_FALSE(read_aedat2_header(std::span(bytes).first(bytes.size() - 20)));
  EXPECT_FALSE(read_aedat2_header(std::span(bytes).first(13)));
  EXPECT_FALSE(read_aedat2_header({}));
  EXPECT_FALSE(read_aedat2_header(Bytes(100)));
}

}  // namespace
}  // namespace asap::aedat2_test
