#include "ros/bridge/packet_reader.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "core/random.hpp"
#include "ros/bridge/package_writer.hpp"
#include "ros/some_events.hpp"

namespace asap::ros::packet_reader_test {
namespace {

using Events = std::vector<Event>;
using Bytes = std::vector<std::uint8_t>;

constexpr Geometry kSensor{640, 480};

Packet packet(const Bytes& bytes, std::uint64_t seq, std::string_view encoding = "evt3",
              std::string_view publisher = "camera") {
  return {.publisher = publisher,
          .sensor = kSensor,
          .seq = seq,
          .encoding = encoding,
          .bytes = std::as_bytes(std::span(bytes))};
}

Events read(PacketReader& reader, const Packet& packet) {
  Events events;
  EXPECT_FALSE(refusal_of(packet));
  reader.see(packet);
  reader.decode(packet,
                [&](EventSpan block) { events.insert(events.end(), block.begin(), block.end()); });
  return events;
}

// One EVT3 stream, cut anywhere: not made of messages that stand alone.
Bytes stream_of(EventSpan events) {
  Bytes bytes;
  PackageWriter("evt3").write(events, bytes);
  return bytes;
}

TEST(PacketReader, ReadsAStreamThatIsCutAnywhere) {
  const Events events = test::some_events(5'000);
  const Bytes bytes = stream_of(events);
  PacketReader reader;
  Events all;
  const CounterRandom random(1);
  std::uint64_t seq = 0;
  for (std::size_t at = 0; at < bytes.size(); ++seq) {
    const std::size_t size = std::min<std::size_t>(2 * (random(seq) % 400), bytes.size() - at);
    const Bytes part(bytes.begin() + static_cast<std::ptrdiff_t>(at),
                     bytes.begin() + static_cast<std::ptrdiff_t>(at + size));
    const Events some = read(reader, packet(part, seq));
    all.insert(all.end(), some.begin(), some.end());
    at += size;
  }
  EXPECT_EQ(all, events);
}

TEST(PacketReader, ADecoderBeginsAnewWithItsPublisher) {
  const Bytes whole = stream_of(test::some_events(600));
  const Bytes rest(whole.begin() + 200, whole.end());  // its row and time came before
  PacketReader reader;
  EXPECT_TRUE(reader.see(packet(whole, 0, "evt3", "left")).is_new);
  EXPECT_TRUE(reader.see(packet(rest, 1, "evt3", "right")).is_new);
  reader.decode(packet(rest, 1, "evt3", "right"), [](EventSpan) {});
  EXPECT_GT(reader.before_start(), 0u);
  EXPECT_EQ(reader.publisher(), "right");
  EXPECT_TRUE(reader.see(packet({}, 2, "mono", "right")).is_new) << "another encoding";
  EXPECT_TRUE(reader.see(packet({}, 1, "mono", "right")).is_new) << "restarted";
}

TEST(PacketReader, WithoutNumbersAStampThatGoesBackBeginsAnew) {
  PacketReader reader;
  const auto see = [&](std::int64_t stamp_ns) {
    Packet decoded = packet({}, 0, kDecoded);
    decoded.stamp_ns = stamp_ns;
    return reader.see(decoded).is_new;
  };
  EXPECT_TRUE(see(100));
  EXPECT_FALSE(see(100));
  EXPECT_FALSE(see(200));
  EXPECT_TRUE(see(199));
}

TEST(PacketReader, RefusesAMessageThatCannotBeRead) {
  const Bytes odd(7), none;
  Packet bad = packet(odd, 0);
  EXPECT_EQ(refusal_of(bad), Refusal::size);
  bad = packet(odd, 0, "mono");
  EXPECT_EQ(refusal_of(bad), Refusal::size);
  bad = packet(none, 0, "evt4");
  EXPECT_EQ(refusal_of(bad), Refusal::encoding);
  bad = packet(none, 0, "trigger");
  EXPECT_EQ(refusal_of(bad), Refusal::encoding);
  bad = packet(none, 0);
  bad.is_bigendian = true;
  EXPECT_EQ(refusal_of(bad), Refusal::big_endian);
  bad = packet(none, 0);
  bad.sensor.width = 0;
  EXPECT_EQ(refusal_of(bad), Refusal::geometry);
  bad.sensor.width = kMostPixels + 1;
  EXPECT_EQ(refusal_of(bad), Refusal::geometry);
  bad.sensor.width = kMostPixels;
  EXPECT_FALSE(refusal_of(bad));
  bad.is_torn = true;
  EXPECT_EQ(refusal_of(bad), Refusal::size);
  EXPECT_EQ(sentence(Refusal::size, packet(odd, 0), "/camera"),
            "size (from /camera, encoding \"evt3\", 640 x 480 px, 7 bytes)");
}

TEST(PacketReader, CountsTheMessagesThatAreMissing) {
  const Bytes none;
  PacketReader reader;
  const auto see = [&](std::uint64_t seq) { return reader.see(packet(none, seq)); };
  EXPECT_TRUE(see(40).is_new);  // the publisher has been there before us
  EXPECT_EQ(see(41).lost, 0u);
  EXPECT_EQ(see(45).lost, 3u);
  reader.refuse(packet(none, 46, "evt4"));
  reader.refuse(packet(none, 47, "evt3", "another"));
  EXPECT_EQ(see(48).lost, 1u);
  const PacketReader::Seen anew = see(0);
  EXPECT_TRUE(anew.is_new);
  EXPECT_EQ(anew.lost, 0u);
  EXPECT_EQ(see(0).lost, 0u);  // it does not count
  EXPECT_FALSE(see(0).is_new);
}

TEST(PacketReader, DropsWhatItCannotPlaceBehindAGap) {
  const Events events = test::some_events(20'000);
  const Bytes bytes = stream_of(events);
  const auto quarter = [&](std::size_t of) {
    const auto at = [&](std::size_t i) {
      return bytes.begin() + static_cast<std::ptrdiff_t>(bytes.size() / 8 * i * 2);
    };
    return Bytes(at(of), at(of + 1));
  };
  PacketReader reader;
  const Bytes first = quarter(0), third = quarter(2);
  const Events before = read(reader, packet(first, 0)), after = read(reader, packet(third, 2));
  EXPECT_GT(reader.before_start(), 0u);
  EXPECT_TRUE(std::ranges::equal(before, std::span(events).first(before.size())));
  EXPECT_GT(after.size(), 2'000u);
  EXPECT_FALSE(std::ranges::search(events, after).empty()) << "what is read was sent";
}

TEST(PacketReader, TakesWhatTheMiddlewareHasDecoded) {
  const Events events = test::some_events(100);
  PacketReader reader;
  Packet decoded = packet({}, 0, kDecoded);
  decoded.events = events;
  EXPECT_EQ(read(reader, decoded), events);
}

TEST(PacketReader, CountsRecordsThatAreNone) {
  const Bytes bytes{0, 0, 0, 0, 0xff, 0xff, 0xff, 0xff};  // a stamp of -1 us
  PacketReader reader;
  EXPECT_TRUE(read(reader, packet(bytes, 0, "libcaer")).empty());
  EXPECT_EQ(reader.bad_records(), 1u);
}

TEST(PacketReader, ReadsTriggers) {
  const Bytes bytes{1, 0x80, 5, 0x60, 1, 0xa1};  // a time, an edge at input 1
  PacketReader reader;
  EXPECT_TRUE(read(reader, packet(bytes, 0)).empty());
  std::vector<Trigger> triggers;
  reader.decode_all(packet(bytes, 0), [&](EventSpan events, std::span<const Trigger> block) {
    EXPECT_TRUE(events.empty());
    triggers.insert(triggers.end(), block.begin(), block.end());
  });
  EXPECT_EQ(triggers, (std::vector<Trigger>{{.t = 4'101, .id = 1, .value = 1}}));
  EXPECT_EQ(reader.triggers(), 2u);
}

}  // namespace
}  // namespace asap::ros::packet_reader_test
