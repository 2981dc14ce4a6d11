#include "ros/bridge/ros1_messages.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "ros/some_events.hpp"

namespace asap::ros::ros1_messages_test {
namespace {

using Bytes = std::vector<std::uint8_t>;

std::span<const std::byte> view(const Bytes& bytes) { return std::as_bytes(std::span(bytes)); }

// Written by hand from the definition of the message.
const Bytes kArray{
    7,    0, 0, 0, 10,   0,   0,   0, 20,   0,    0, 0,      // header: seq, 10 s + 20 ns
    3,    0, 0, 0, 'c',  'a', 'm',                           // frame_id
    0xe0, 1, 0, 0, 0x80, 2,   0,   0,                        // height, width
    2,    0, 0, 0,                                           // events
    0x2c, 1, 5, 0, 3,    0,   0,   0, 0xe8, 0x03, 0, 0, 1,   // 300, 5, 3 s + 1 us, ON
    1,    0, 0, 1, 3,    0,   0,   0, 0xff, 0x0b, 0, 0, 0};  // 1, 256, 3 s + 3.071 us
const std::vector<Event> kEvents{{.x = 300, .y = 5, .p = 1, .t = 3'000'001},
                                 {.x = 1, .y = 256, .p = 0, .t = 3'000'003}};

const Bytes kPacket{9, 0, 0, 0, 1,   0,   0,   0,   0, 0, 0, 0, 0, 0, 0, 0,  // header
                    2, 0, 0, 0, 3,   0,   0,   0,                            // height, width
                    5, 0, 0, 0, 1,   0,   0,   0,                            // seq
                    6, 0, 0, 0, 0,   2,   0,   0,                            // time_base
                    4, 0, 0, 0, 'm', 'o', 'n', 'o', 1,                       // big-endian
                    3, 0, 0, 0, 8,   9,   10};

struct Ros1Reader {
  Packet read(std::string_view md5, std::span<const std::byte> bytes) {
    return read_ros1(md5, bytes, events);
  }
  std::vector<Event> events;
};

TEST(Ros1Messages, ReadsAnEventArray) {
  Ros1Reader reader;
  const auto read = reader.read(kEventArray.md5, view(kArray));
  EXPECT_EQ(read.encoding, kDecoded);
  EXPECT_EQ(read.sensor, (Geometry{640, 480}));
  EXPECT_EQ(read.seq, 7);
  EXPECT_EQ(read.stamp_ns, 10'000'000'020);
  EXPECT_EQ(read.frame_id, "cam");
  EXPECT_FALSE(read.is_torn);
  EXPECT_TRUE(std::ranges::equal(read.events, kEvents));
}

TEST(Ros1Messages, ReadsAnEventPacket) {
  Ros1Reader reader;
  const auto read = reader.read(kEventPacket.md5, view(kPacket));
  EXPECT_EQ(read.encoding, "mono");
  EXPECT_EQ(read.sensor, (Geometry{3, 2}));
  EXPECT_EQ(read.seq, (std::uint64_t{1} << 32) + 5);
  EXPECT_EQ(read.time_base, (std::uint64_t{0x200} << 32) + 6);
  EXPECT_TRUE(read.is_bigendian);
  EXPECT_FALSE(read.is_torn);
  EXPECT_TRUE(std::ranges::equal(read.bytes, view({8, 9, 10})));
}

// Cut at every place, and with one byte more.
TEST(Ros1Messages, KnowsATornMessage) {
  for (const auto& [type, whole] : {std::pair(&kEventArray, &kArray), {&kEventPacket, &kPacket}}) {
    for (std::size_t size = 0; size < whole->size(); ++size) {
      Ros1Reader reader;
      const Bytes part(whole->begin(), whole->begin() + static_cast<std::ptrdiff_t>(size));
      const Packet packet = reader.read(type->md5, view(part));
      EXPECT_TRUE(packet.is_torn) << type->name << " " << size;
      EXPECT_TRUE(packet.events.empty() && packet.bytes.empty());
    }
    Bytes longer = *whole;
    longer.push_back(0);
    EXPECT_TRUE(Ros1Reader().read(type->md5, view(longer)).is_torn);
  }
}

TEST(Ros1Messages, ReadsNoOtherType) {
  const Packet packet = Ros1Reader().read("d41d8cd98f00b204e9800998ecf8427e", view(kArray));
  EXPECT_EQ(packet.encoding, "another type");
  EXPECT_FALSE(packet.is_torn);
}

TEST(Ros1Messages, WritesAnEventArrayByteForByte) {
  Bytes bytes{1, 2, 3};
  write_ros1({.sensor = {640, 480},
              .stamp_ns = 10'000'000'020,
              .seq = 7,
              .encoding = kDecoded,
              .events = kEvents},
             "cam", bytes);
  Bytes expected = kArray;
  expected.at(expected.size() - 5) = 0xb8;  // 3 us: the nanoseconds are the sensor's, not ours
  EXPECT_EQ(bytes, expected);
}

TEST(Ros1Messages, ReadsWhatItWrites) {
  const auto events = test::some_events(1000);
  Bytes bytes;
  write_ros1({.sensor = {640, 480}, .encoding = kDecoded, .events = events}, "", bytes);
  Ros1Reader reader;
  EXPECT_TRUE(std::ranges::equal(reader.read(kEventArray.md5, view(bytes)).events, events));

  write_ros1({.sensor = {640, 480},
              .stamp_ns = 5,
              .seq = (std::uint64_t{1} << 40) + 3,
              .time_base = 99,
              .encoding = "evt3",
              .bytes = {1, 2, 3, 4}},
             "camera", bytes);
  const auto read = reader.read(kEventPacket.md5, view(bytes));
  EXPECT_FALSE(read.is_torn);
  EXPECT_EQ(read.encoding, "evt3");
  EXPECT_EQ(read.seq, (std::uint64_t{1} << 40) + 3);
  EXPECT_EQ(read.time_base, 99);
  EXPECT_EQ(read.sensor, (Geometry{640, 480}));
  EXPECT_FALSE(read.is_bigendian);
  EXPECT_EQ(read.stamp_ns, 5);
  EXPECT_EQ(read.frame_id, "camera");
  EXPECT_TRUE(std::ranges::equal(read.bytes, view({1, 2, 3, 4})));
}

}  // namespace
}  // namespace asap::ros::ros1_messages_test
