#include "formats/records.hpp"

#include <gtest/gtest.h>

#include "support/decoding.hpp"

namespace asap::records_test {
namespace {

using test::Bytes;
using test::Events;

TEST(Records, LoadInEitherOrder) {
  Bytes bytes;
  test::append(bytes, {1, 2, 3, 4, 5, 6, 7, 8});
  EXPECT_EQ(records::load<false>(bytes.data()), 0x0807060504030201u);
  EXPECT_EQ(records::load<true>(bytes.data()), 0x0102030405060708u);
  EXPECT_EQ(records::load<false>(bytes.data(), 3), 0x030201u);
  EXPECT_EQ(records::load<true>(bytes.data(), 3), 0x0102030000000000u);
}

TEST(Records, StoreEveryField) {
  Event event{};
  records::store(&event, 0xfffe'0001u, 1, -5);
  EXPECT_EQ(event, (Event{1, 0xfffe, 1, -5}));
}

// Two bytes: 0 is none, the second is x.
struct Pairs {
  static constexpr std::size_t kRecord = 2;
  static constexpr bool kBigEndian = false;
  std::size_t taken = 0;

  static std::size_t size(std::uint64_t) noexcept { return kRecord; }
  static bool is_event(std::uint64_t word) noexcept { return (word & 0xff) != 0; }
  std::size_t take(std::uint64_t word, Event* to) noexcept {
    ++taken;
    records::store(to, static_cast<std::uint32_t>(word >> 8 & 0xff), 0, 0);
    return is_event(word);
  }
};

TEST(Records, AreTakenOnceEachAndKeptWhereCut) {
  Bytes bytes;
  test::append(bytes, {1, 10, 0, 11, 1, 12, 1, 13, 0, 14, 1, 15, 0, 16, 1});
  Pairs format;
  std::array<std::byte, 8> kept{};
  std::size_t kept_size = 0;
  Events events(3);
  const Progress first = records::decode_records(format, {kept, kept_size}, bytes, events);
  EXPECT_EQ(first.events, 3u);
  EXPECT_EQ(first.bytes, 10u);  // the record that needs no room as well
  const auto rest = std::span(bytes).subspan(first.bytes);
  const Progress second = records::decode_records(format, {kept, kept_size}, rest, events);
  EXPECT_EQ(second.events, 1u);
  EXPECT_EQ(second.bytes, 5u);
  EXPECT_EQ(kept_size, 1u);
  EXPECT_EQ(events[0].x, 15);
  Bytes last;
  test::append(last, {17});
  EXPECT_EQ(records::decode_records(format, {kept, kept_size}, last, {}).bytes, 0u);
  EXPECT_EQ(records::decode_records(format, {kept, kept_size}, last, events).events, 1u);
  EXPECT_EQ(events[0].x, 17);
  EXPECT_EQ(kept_size, 0u);
  EXPECT_EQ(format.taken, 8u);
}

}  // namespace
}  // namespace asap::records_test
