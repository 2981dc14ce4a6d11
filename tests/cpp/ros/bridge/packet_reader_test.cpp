#include "ros/bridge/packet_reader.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "asap/core/random.hpp"
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
  EXPECT_FALSE(reader.see(packet).refusal);
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

TEST(PacketReader, KeepsADecoderPerPublisher) {
  const Events left = test::some_events(600), right = test::some_events(600, 3'000'000);
  const Bytes of_left = stream_of(left), of_right = stream_of(right);
  const auto half = [](const Bytes& bytes, bool second) {
    const auto middle = bytes.begin() + static_cast<std::ptrdiff_t>(bytes.size() / 4 * 2);
    return second ? Bytes(middle, bytes.end()) : Bytes(bytes.begin(), middle);
  };
  PacketReader reader;
  Events seen_left, seen_right;
  for (const bool second : {false, true}) {
    const Bytes l = half(of_left, second), r = half(of_right, second);
    const Events from_left = read(reader, packet(l, second, "evt3", "left"));
    const Events from_right = read(reader, packet(r, second, "evt3", "right"));
    seen_left.insert(seen_left.end(), from_left.begin(), from_left.end());
    seen_right.insert(seen_right.end(), from_right.begin(), from_right.end());
  }
  EXPECT_EQ(seen_left, left);
  EXPECT_EQ(seen_right, right);
}

TEST(PacketReader, RefusesAMessageThatCannotBeRead) {
  const Bytes odd(7), none;
  PacketReader reader;
  Packet bad = packet(odd, 0);
  EXPECT_EQ(reader.see(bad).refusal, Refusal::size);
  bad = packet(odd, 0, "mono");
  EXPECT_EQ(reader.see(bad).refusal, Refusal::size);
  bad = packet(none, 0, "evt4");
  EXPECT_EQ(reader.see(bad).refusal, Refusal::encoding);
  bad = packet(none, 0, "trigger");
  EXPECT_EQ(reader.see(bad).refusal, Refusal::encoding);
  bad = packet(none, 0);
  bad.is_bigendian = true;
  EXPECT_EQ(reader.see(bad).refusal, Refusal::big_endian);
  bad = packet(none, 0);
  bad.sensor.width = 0;
  EXPECT_EQ(reader.see(bad).refusal, Refusal::geometry);
  bad.sensor.width = kMostPixels + 1;
  EXPECT_EQ(reader.see(bad).refusal, Refusal::geometry);
  bad.sensor.width = kMostPixels;
  EXPECT_FALSE(reader.see(bad).refusal);
  bad.is_torn = true;
  EXPECT_EQ(reader.see(bad).refusal, Refusal::size);
  EXPECT_EQ(sentence(Refusal::size, packet(odd, 0)),
            "message refused: size (encoding \"evt3\", 640 x 480 px, 7 bytes)");
}

TEST(PacketReader, CountsTheMessagesThatAreMissing) {
  const Bytes none;
  PacketReader reader;
  const auto see = [&](std::uint64_t seq) { return reader.see(packet(none, seq)); };
  EXPECT_TRUE(see(40).is_new);  // the publisher has been there before us
  EXPECT_EQ(see(41).lost, 0u);
  EXPECT_EQ(see(45).lost, 3u);
  const Packet refused = packet(none, 46, "evt4");
  EXPECT_EQ(reader.see(refused).lost, 0u);
  EXPECT_EQ(see(47).lost, 0u);
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

TEST(PacketReader, RemembersFewPublishers) {
  const Bytes none;
  PacketReader reader;
  for (std::size_t i = 0; i < 100; ++i) {
    const std::string publisher = std::to_string(i);
    EXPECT_TRUE(reader.see(packet(none, 5, "evt3", publisher)).is_new);
    EXPECT_EQ(reader.see(packet(none, 6, "evt3", publisher)).is_new, false);
  }
  EXPECT_FALSE(reader.see(packet(none, 7, "evt3", "93")).is_new);
  EXPECT_TRUE(reader.see(packet(none, 7, "evt3", "91")).is_new);
}

TEST(PacketReader, CountsRecordsThatAreNone) {
  const Bytes bytes{0, 0, 0, 0, 0xff, 0xff, 0xff, 0xff};  // a stamp of -1 us
  PacketReader reader;
  EXPECT_TRUE(read(reader, packet(bytes, 0, "libcaer")).empty());
  EXPECT_EQ(reader.bad_records(), 1u);
}

}  // namespace
}  // namespace asap::ros::packet_reader_test
