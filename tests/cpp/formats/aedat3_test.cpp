#include "asap/formats/aedat.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

#include "formats/decoding.hpp"

namespace asap::aedat3_test {
namespace {

using namespace decoding;

struct Packet {
  unsigned type = 1, source = 0, event_size = 8, time_at = 4, overflows = 0;
  unsigned events = 0, valid = 0;
};

void append_packet(Bytes& bytes, const Packet& packet) {
  append_little(bytes, packet.type, 2);
  append_little(bytes, packet.source, 2);
  for (const unsigned field : {packet.event_size, packet.time_at, packet.overflows, packet.events,
                               packet.events, packet.valid}) {
    append_little(bytes, field, 4);
  }
}

void append_event(Bytes& bytes, unsigned x, unsigned y, unsigned p, unsigned t,
                  unsigned valid = 1) {
  append_little(bytes, valid | p << 1 | y << 2 | x << 17, 4);
  append_little(bytes, t, 4);
}

void append_special(Bytes& bytes, unsigned type, unsigned t = 7, unsigned valid = 1) {
  append_little(bytes, valid | type << 1 | 0xabcdef00, 4);
  append_little(bytes, t, 4);
}

TEST(Aedat3Decoder, DecodesEveryField) {
  Bytes bytes;
  append_packet(bytes, {.overflows = 3, .events = 3, .valid = 2});
  append_event(bytes, 0x7fff, 0, 0, 0x7fff'ffff);
  append_event(bytes, 1, 2, 1, 3, 0);
  append_event(bytes, 0, 0x7fff, 1, 5);
  Aedat3Decoder decoder;
  Decoded decoded;
  feed(decoder, bytes, 9, decoded);
  const auto wrap = std::int64_t{1} << 31;
  EXPECT_EQ(decoded.events, (Events{{0x7fff, 0, 0, 4 * wrap - 1}, {0, 0x7fff, 1, 3 * wrap + 5}}));
  EXPECT_EQ(decoder.invalid(), 1u);
  EXPECT_EQ(decoder.bad_records(), 0u);
}

TEST(Aedat3Decoder, GivesTriggersAndSkipsOtherPackets) {
  Bytes bytes;
  append_packet(bytes, {.type = 0, .overflows = 1, .events = 6, .valid = 6});
  for (const unsigned type : {0u, 1u, 2u, 3u, 4u, 5u}) append_special(bytes, type, 10 + type);
  append_packet(bytes, {.type = 0, .events = 1});
  append_special(bytes, 2, 16, 0);
  append_packet(bytes, {.type = 2, .event_size = 60, .time_at = 4, .events = 1});
  bytes.resize(bytes.size() + 60);
  append_packet(bytes, {.events = 1, .valid = 1});
  append_event(bytes, 4, 5, 1, 6);
  Aedat3Decoder decoder;
  Decoded decoded;
  feed(decoder, bytes, 9, decoded);
  EXPECT_EQ(decoded.events, (Events{{4, 5, 1, 6}}));
  const auto wrap = std::int64_t{1} << 31;
  EXPECT_EQ(decoded.triggers, (Triggers{{wrap + 12, 0, 1}, {wrap + 13, 0, 0}, {wrap + 14, 0, 1}}));
  EXPECT_EQ(decoder.triggers(), 3u);
}

TEST(Aedat3Decoder, TakesTheSourceThatIsAskedFor) {
  Bytes bytes;
  append_packet(bytes, {.source = 0, .events = 1, .valid = 1});
  append_event(bytes, 4, 5, 1, 6);
  append_packet(bytes, {.source = 1, .events = 1, .valid = 1});
  append_event(bytes, 7, 8, 0, 9);
  EXPECT_EQ(events_of(Aedat3Decoder(), bytes).size(), 2u);
  EXPECT_EQ(events_of(Aedat3Decoder({.source = 1}), bytes), (Events{{7, 8, 0, 9}}));
  EXPECT_THROW(Aedat3Decoder({.source = -2}), std::invalid_argument);
}

TEST(Aedat3Decoder, AFileCutBetweenTwoEventsOfAPacketIsCut) {
  Bytes bytes;
  append_packet(bytes, {.events = 2, .valid = 2});
  append_event(bytes, 4, 5, 1, 6);
  Aedat3Decoder decoder;
  Decoded decoded;
  feed(decoder, bytes, 9, decoded);
  EXPECT_EQ(decoded.events.size(), 1u);
  EXPECT_EQ(decoder.unfinished(), 36u);
}

// Packets are found again after bytes that are none; each such stretch is counted once.
TEST(Aedat3Decoder, FindsTheNextPacketAfterBadBytes) {
  Bytes good;
  append_packet(good, {.events = 1, .valid = 1});
  append_event(good, 4, 5, 1, 6);
  Bytes bytes = good;
  bytes.resize(bytes.size() + 101, std::byte{0xee});
  bytes.insert(bytes.end(), good.begin(), good.end());
  append_packet(bytes, {.event_size = 9, .events = 1});  // no size of a polarity event
  bytes.insert(bytes.end(), good.begin(), good.end());
  Aedat3Decoder decoder({.first_offset = 1000});
  Decoded decoded;
  feed(decoder, bytes, 9, decoded);
  EXPECT_EQ(decoded.events, (Events{{4, 5, 1, 6}, {4, 5, 1, 6}, {4, 5, 1, 6}}));
  EXPECT_EQ(decoder.bad_records(), 2u);
  ASSERT_EQ(decoder.noted().size(), 2u);
  EXPECT_EQ(decoder.noted()[0], 1036u);
  EXPECT_EQ(decoder.noted()[1], 1036u + 101 + 36);
  const Aedat3Decoder fresh({.first_offset = 1000});
  for (std::size_t piece = 1; piece < 40; ++piece) {
    EXPECT_EQ(decode(fresh, bytes, piece), decode(fresh, bytes)) << piece;
  }
}

TEST(Aedat3Decoder, RefusesHeadersThatCannotBe) {
  const auto bad = [](const Packet& packet) {
    Bytes bytes;
    append_packet(bytes, packet);
    return decode(Aedat3Decoder(), bytes).bad_records == 1;
  };
  EXPECT_FALSE(bad({}));
  EXPECT_TRUE(bad({.type = 0x8001}));
  EXPECT_TRUE(bad({.source = 0xffff}));
  EXPECT_TRUE(bad({.event_size = 0}));
  EXPECT_TRUE(bad({.time_at = 3}));
  EXPECT_TRUE(bad({.type = 5, .event_size = 8, .time_at = 8}));
  EXPECT_TRUE(bad({.overflows = 0x8000'0000}));
  EXPECT_TRUE(bad({.events = 0x8000'0000}));
  EXPECT_TRUE(bad({.events = 1, .valid = 2}));
}

Bytes file(std::string_view lines) {
  Bytes bytes;
  append(bytes, "#!AER-DAT3.1\r\n");
  append(bytes, lines);
  append(bytes, "#!END-HEADER\r\n");
  append_packet(bytes, {});
  return bytes;
}

TEST(Aedat3Header, SaysWhatTheFileHolds) {
  const Bytes bytes = file(
      "#Format: RAW\r\n#Source 0: DAVIS346\r\n#-Source 0: DVS128\r\n"
      "#Start-Time: 2021-10-11 00:00:00 (TZ+0000)\r\n");
  const auto header = read_aedat3_header(bytes);
  ASSERT_TRUE(header);
  EXPECT_EQ(header->size, bytes.size() - 28);
  EXPECT_TRUE(header->raw);
  EXPECT_EQ(header->sources, 1u);
  EXPECT_EQ(header->width, 346);
  EXPECT_EQ(header->height, 260);
  EXPECT_FALSE(read_aedat3_header(file("#Format: SerializedTS\r\n"))->raw);
  EXPECT_EQ(read_aedat3_header(file("#Source 0: DVS128\r\n#Source 1: DAVIS240C\r\n"))->sources, 2u);
  EXPECT_EQ(read_aedat3_header(file("#Source 0: File\r\n"))->width, 0);
}

TEST(Aedat3Header, IsNothingWithoutItsEndOrOfOtherFiles) {
  const Bytes bytes = file("#Format: RAW\r\n");
  for (std::size_t size = 0; size < bytes.size() - 28; ++size) {
    EXPECT_FALSE(read_aedat3_header(std::span(bytes).first(size))) << size;
  }
  Bytes other;
  append(other, "#!AER-DAT3.1\r\nno comment\r\n#!END-HEADER\r\n");
  EXPECT_FALSE(read_aedat3_header(other));
  EXPECT_FALSE(read_aedat3_header(Bytes(100)));
}

}  // namespace
}  // namespace asap::aedat3_test
