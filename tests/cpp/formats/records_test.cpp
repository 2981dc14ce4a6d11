#include "formats/records.hpp"

#include <gtest/gtest.h>

#include "formats/decoding.hpp"

namespace asap::records_test {
namespace {

using namespace decoding;

TEST(Records, LoadInEitherOrder) {
  Bytes bytes;
  append(bytes, {1, 2, 3, 4, 5, 6, 7, 8});
  EXPECT_EQ(records::load<false>(bytes.data()), 0x0807060504030201u);
  EXPECT_EQ(records::load<true>(bytes.data()), 0x0102030405060708u);
  EXPECT_EQ(records::load<false>(bytes.data(), 3), 0x030201u);
  EXPECT_EQ(records::load<true>(bytes.data(), 3), 0x0102030000000000u);
}

// Two bytes: 0 is none, the second is x.
struct Pairs {
  static constexpr std::size_t kRecord = 2;
  static constexpr bool kBigEndian = false;
  std::size_t taken = 0;

  static std::size_t size(std::uint64_t) noexcept { return kRecord; }
  static bool waits(std::uint64_t, const Output&) noexcept { return false; }
  static bool is_event(std::uint64_t word) noexcept { return (word & 0xff) != 0; }
  std::size_t take(std::uint64_t word, Event* to, Output&) noexcept {
    ++taken;
    write_event(to, word >> 8 & 0xff, 0, 0, 0);
    return is_event(word);
  }
};

TEST(Records, AreTakenOnceEachAndKeptWhereCut) {
  Bytes bytes;
  append(bytes, {1, 10, 0, 11, 1, 12, 1, 13, 0, 14, 1, 15, 0, 16, 1});
  Pairs format;
  CutRecord<2> cut;
  Events events(3);
  const auto decode = [&](std::span<const std::byte> from, std::span<Event> to) {
    Output out = output_to(to);
    const std::size_t used = records::decode_records(format, cut, from, out);
    return out.since(output_to(to), used);
  };
  const Progress first = decode(bytes, events);
  EXPECT_EQ(first.events, 3u);
  EXPECT_EQ(first.bytes, 10u);  // the record that needs no room as well
  const Progress second = decode(std::span(bytes).subspan(first.bytes), events);
  EXPECT_EQ(second.events, 1u);
  EXPECT_EQ(second.bytes, 5u);
  EXPECT_EQ(cut.size, 1u);
  EXPECT_EQ(events[0].x, 15);
  Bytes last;
  append(last, {17});
  EXPECT_EQ(decode(last, {}).bytes, 0u);
  EXPECT_EQ(decode(last, events).events, 1u);
  EXPECT_EQ(events[0].x, 17);
  EXPECT_EQ(cut.size, 0u);
  EXPECT_EQ(format.taken, 8u);
}

}  // namespace
}  // namespace asap::records_test
