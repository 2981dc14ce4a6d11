#include "ros/bridge/package_writer.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "ros/bridge/packet_reader.hpp"
#include "ros/some_events.hpp"
#include "support/errors.hpp"

namespace asap::ros::package_writer_test {
namespace {

using Events = std::vector<Event>;

// What a reader makes of the messages; `alone`: of each by itself.
Events read_back(const std::string& encoding, const std::vector<Events>& packages, bool alone) {
  PackageWriter writer(encoding);
  PacketReader reader;
  Events all;
  std::vector<std::uint8_t> bytes;
  std::uint64_t seq = 0;
  for (const Events& package : packages) {
    for (EventSpan rest = package; !rest.empty(); ++seq) {
      const PackageWriter::Written written = writer.write(rest, bytes);
      rest = rest.subspan(written.events);
      const Packet packet{.publisher = "asap",
                          .sensor = {640, 480},
                          .seq = seq,
                          .time_base = written.time_base,
                          .encoding = encoding,
                          .bytes = std::as_bytes(std::span(bytes))};
      if (alone) reader = PacketReader();
      EXPECT_FALSE(refusal_of(packet));
      reader.see(packet);
      reader.decode(packet,
                    [&](EventSpan block) { all.insert(all.end(), block.begin(), block.end()); });
    }
  }
  return all;
}

TEST(PackageWriter, PutsTriggersBetweenTheEvents) {
  constexpr std::int64_t kLate = 20'000'000'000;  // hours of marks; the reader counts modulo 2^24
  const Events events{{1, 1, 1, 100}, {2, 1, 0, 200}, {3, 2, 1, 200}, {4, 2, 1, kLate}};
  const std::vector<Trigger> triggers{
      {50, 1, 1}, {200, 15, 0}, {250, 0, 1}, {10'000'000'000, 2, 1}, {kLate + 7, 3, 0}};
  PackageWriter writer("evt3");
  std::vector<std::uint8_t> bytes;
  for (int package = 0; package < 2; ++package) writer.write(events, bytes, triggers);
  PacketReader reader;
  const Packet packet{.publisher = "asap",
                      .sensor = {640, 480},
                      .encoding = "evt3",
                      .bytes = std::as_bytes(std::span(bytes))};
  reader.see(packet);
  Events read;
  std::vector<Trigger> passed;
  reader.decode_all(packet, [&](EventSpan block, std::span<const Trigger> more) {
    read.insert(read.end(), block.begin(), block.end());
    passed.insert(passed.end(), more.begin(), more.end());
  });
  EXPECT_EQ(read, events);
  EXPECT_EQ(passed, triggers);
}

std::vector<Events> cut(const Events& events, std::size_t size) {
  std::vector<Events> packages;
  for (std::size_t at = 0; at < events.size(); at += size) {
    const EventSpan part = EventSpan(events).subspan(at, std::min(size, events.size() - at));
    packages.emplace_back(part.begin(), part.end());
  }
  return packages;
}

Events joined(const std::vector<Events>& packages) {
  Events all;
  for (const Events& package : packages) all.insert(all.end(), package.begin(), package.end());
  return all;
}

TEST(PackageWriter, WritesWhatAReaderReads) {
  for (const char* encoding : {"mono", "evt3"}) {
    for (const std::size_t size : {1u, 7u, 1'000u, 5'000u}) {
      const std::vector<Events> packages = cut(test::some_events(5'000), size);
      EXPECT_EQ(read_back(encoding, packages, false), joined(packages)) << encoding << size;
    }
  }
}

TEST(PackageWriter, EveryMessageIsReadAlone) {
  const std::vector<Events> packages = cut(test::some_events(5'000), 100);
  EXPECT_EQ(read_back("mono", packages, true), joined(packages));
  EXPECT_EQ(read_back("evt3", packages, true), joined(packages));  // within 2^24 us of 0
}

TEST(PackageWriter, MonoKeepsAnyTime) {
  const std::int64_t now_us = 1'700'000'000'123'456;
  const std::vector<Events> packages{{{1, 2, 1, now_us}, {3, 4, 0, now_us + 4'294'967}},
                                     {{5, 6, 1, now_us + 4'294'968}}};
  EXPECT_EQ(read_back("mono", packages, true), joined(packages));
}

TEST(PackageWriter, MonoSplitsWhatOneTimeBaseDoesNotReach) {
  const Events events{
      {1, 2, 1, 10}, {3, 4, 0, 4'294'977}, {5, 6, 1, 4'294'978}, {7, 8, 1, 9'000'000}};
  PackageWriter writer("mono");
  std::vector<std::uint8_t> bytes;
  EXPECT_EQ(writer.write(events, bytes).events, 2u);
  EXPECT_EQ(read_back("mono", {events}, true), events);
}

TEST(PackageWriter, Evt3KeepsTheTimesBetweenEvents) {
  std::vector<Events> packages;
  std::int64_t t = 1'700'000'000'123'456;
  for (std::uint16_t y = 1; y <= 3; ++y) {
    packages.push_back({{1, y, 1, t += 5}, {2, y, 0, t += 23'000'000}});  // EVT3 wraps
  }
  const Events seen = read_back("evt3", packages, false), sent = joined(packages);
  ASSERT_EQ(seen.size(), sent.size());
  for (std::size_t i = 0; i < sent.size(); ++i) {
    EXPECT_EQ(seen[i].t - seen[0].t, sent[i].t - sent[0].t);
    EXPECT_EQ(seen[i].t & 0xffffff, sent[i].t & 0xffffff);
  }
}

TEST(PackageWriter, Evt3BeginsAnewWhereTheStampsDo) {
  const std::vector<Events> packages{
      {{1, 2, 1, 9'000'000}}, {{3, 4, 0, 5}}, {{5, 6, 1, std::int64_t{1} << 50}}};
  EXPECT_EQ(read_back("evt3", packages, false).size(), 3u);
}

TEST(PackageWriter, NamesTheEncodingsItKnows) {
  EXPECT_EQ(test::error_of([] { PackageWriter writer("evt2"); }), "encoding = evt2: mono or evt3");
}

}  // namespace
}  // namespace asap::ros::package_writer_test
