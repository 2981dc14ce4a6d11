#include "asap/formats/packets.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>

#include "core/random.hpp"
#include "formats/decoding.hpp"

namespace asap::packets_test {
namespace {

using decoding::Bytes;
using decoding::Events;

constexpr std::uint64_t kBase = 1'700'000'000'123'456'789;  // ns

template <class Word>
void append(Bytes& bytes, Word word) {
  for (std::size_t i = 0; i < sizeof word; ++i) {
    bytes.push_back(static_cast<std::byte>(static_cast<std::uint64_t>(word) >> (8 * i) & 0xff));
  }
}

template <class Word>
Bytes bytes_of(std::initializer_list<Word> words) {
  Bytes bytes;
  for (const Word word : words) append(bytes, word);
  return bytes;
}

std::uint64_t mono(std::uint64_t ns, std::uint64_t x, std::uint64_t y, std::uint64_t p) {
  return ns | x << 32 | y << 48 | p << 63;
}

std::uint64_t libcaer(std::int32_t us, std::uint64_t x, std::uint64_t y, std::uint64_t p) {
  return std::uint64_t{static_cast<std::uint32_t>(us)} << 32 | x << 17 | y << 2 | p << 1 | 1;
}

enum Code { kTimeHigh, kTimeLow, kAddrX, kAddrY, kVectBaseY, kVect8 };

std::uint16_t cmp(int code, int value, int p = 0) {
  return static_cast<std::uint16_t>(code << 12 | p << 11 | value);
}

template <class Decoder>
Decoder begun(std::uint64_t base = kBase) {
  Decoder decoder;
  decoder.begin(base);
  return decoder;
}

// Leaves the decoder behind `bytes`.
template <class Decoder>
Events decode(Decoder& decoder, const Bytes& bytes) {
  decoding::Decoded decoded;
  decoding::feed(decoder, bytes, 4096, decoded);
  return decoded.events;
}

template <class Decoder>
Events decode(const Bytes& bytes, std::uint64_t base = kBase) {
  return decoding::decode(begun<Decoder>(base), bytes).events;
}

// Random words that the format can hold; one in 64 can be none.
template <class Decoder>
Bytes random_message(std::uint64_t seed, std::size_t words) {
  const CounterRandom random(seed);
  Bytes bytes;
  for (std::size_t i = 0; i < words; ++i) {
    const std::uint64_t any = random(i);
    if constexpr (std::is_same_v<Decoder, LibcaerCmpDecoder>) {
      const auto code = any % 64 == 0 ? 6 + any / 64 % 10 : any / 64 % 6;
      append(bytes, static_cast<std::uint16_t>(code << 12 | (any >> 20 & 0xfff)));
    } else {
      append(bytes, any);
    }
  }
  return bytes;
}

template <class Decoder>
class Packets : public testing::Test {};
using Decoders = testing::Types<MonoDecoder, LibcaerDecoder, LibcaerCmpDecoder>;
TYPED_TEST_SUITE(Packets, Decoders);

TYPED_TEST(Packets, ARecordCutByTheNextMessageIsBad) {
  const Bytes bytes = random_message<TypeParam>(5, 10);
  TypeParam decoder({.first_offset = 100});
  decoder.begin(kBase);
  decode(decoder, bytes);
  const std::uint64_t bad = decoder.bad_records();
  decoder.begin(kBase);
  EXPECT_EQ(decoder.bad_records(), bad);
  decode(decoder, Bytes(1));
  decoder.begin(kBase);
  EXPECT_EQ(decoder.bad_records(), bad + 1);
  EXPECT_EQ(decoder.noted().back(), 100 + bytes.size());
  EXPECT_EQ(decoder.unfinished(), 0u);
}

TEST(MonoDecoder, AddsNanosecondsToTheBase) {
  const Bytes bytes = bytes_of({mono(0, 1, 2, 0), mono(210, 65535, 32767, 1), mono(211, 0, 0, 1),
                                mono(0xffffffff, 320, 240, 0)});
  const std::int64_t us = 1'700'000'000'123'456;
  EXPECT_EQ(
      decode<MonoDecoder>(bytes),
      (Events{
          {1, 2, 0, us}, {65535, 32767, 1, us}, {0, 0, 1, us + 1}, {320, 240, 0, us + 4'294'968}}));
}

TEST(MonoDecoder, TakesAnyBase) {
  const Bytes bytes = bytes_of({mono(0xffffffff, 1, 2, 0)});
  const std::uint64_t max = ~std::uint64_t{0};
  EXPECT_EQ(decode<MonoDecoder>(bytes, max).at(0).t, 18'446'744'073'709'551 + 4'294'967);
}

TEST(LibcaerDecoder, AddsMicrosecondsToTheBase) {
  const Bytes bytes = bytes_of({libcaer(0, 1, 2, 0), libcaer(5, 32767, 32767, 1)});
  const std::int64_t us = 1'700'000'000'123'456;
  EXPECT_EQ(decode<LibcaerDecoder>(bytes), (Events{{1, 2, 0, us}, {32767, 32767, 1, us + 5}}));
}

TEST(LibcaerDecoder, WrapsWithinAMessage) {
  const Bytes bytes = bytes_of({libcaer(0x7fffffff, 1, 2, 0), libcaer(0, 1, 2, 0)});
  const Events events = decode<LibcaerDecoder>(bytes, 0);
  EXPECT_EQ(events.at(0).t, 0x7fffffff);
  EXPECT_EQ(events.at(1).t, 0x80000000);
}

TEST(LibcaerDecoder, ASmallStepBackIsNoWrap) {
  const Bytes bytes = bytes_of({libcaer(1000, 1, 2, 0), libcaer(990, 1, 2, 0)});
  EXPECT_EQ(decode<LibcaerDecoder>(bytes, 0).at(1).t, 990);
}

TEST(LibcaerDecoder, EachMessageBeginsAnew) {
  LibcaerDecoder decoder;
  decoder.begin(0);
  decode(decoder, bytes_of({libcaer(0x7fffffff, 1, 2, 0), libcaer(3, 1, 2, 0)}));
  decoder.begin(1000);
  EXPECT_EQ(decode(decoder, bytes_of({libcaer(7, 1, 2, 0)})).at(0).t, 8);
}

TEST(LibcaerDecoder, ANegativeStampIsABadRecord) {
  LibcaerDecoder decoder({.first_offset = 50});
  decoder.begin(0);
  const Events events =
      decode(decoder, bytes_of({libcaer(4, 1, 2, 0), libcaer(-4, 1, 2, 0), libcaer(5, 3, 4, 1)}));
  EXPECT_EQ(events, (Events{{1, 2, 0, 4}, {3, 4, 1, 5}}));
  EXPECT_EQ(decoder.bad_records(), 1u);
  EXPECT_EQ(decoder.noted()[0], 58u);
}

TEST(LibcaerCmpDecoder, DecodesEveryWord) {
  const Bytes bytes =
      bytes_of({cmp(kAddrX, 600), cmp(kAddrY, 470, 1), cmp(kTimeLow, 4095), cmp(kAddrY, 2047, 0),
                cmp(kTimeHigh, 3), cmp(kTimeLow, 1), cmp(kAddrX, 5), cmp(kVectBaseY, 16, 1),
                cmp(kVect8, 0b10000101), cmp(kVect8, 0), cmp(kVect8, 1), cmp(kAddrY, 9, 0)});
  const std::int64_t us = 1'700'000'000'123'456, late = us + 3 * 4096 + 1;
  EXPECT_EQ(decode<LibcaerCmpDecoder>(bytes), (Events{{600, 470, 1, us},
                                                      {600, 2047, 0, us + 4095},
                                                      {5, 16, 1, late},
                                                      {5, 18, 1, late},
                                                      {5, 23, 1, late},
                                                      {5, 32, 1, late},
                                                      {5, 9, 0, late}}));
}

TEST(LibcaerCmpDecoder, TimeBeginsAnewWithEachMessage) {
  LibcaerCmpDecoder decoder;
  decoder.begin(0);
  decode(decoder, bytes_of({cmp(kTimeHigh, 7), cmp(kTimeLow, 7), cmp(kAddrX, 3)}));
  decoder.begin(5'000'999);
  EXPECT_EQ(decode(decoder, bytes_of({cmp(kAddrY, 4)})), (Events{{3, 4, 0, 5000}}));
}

TEST(LibcaerCmpDecoder, OtherCodesAreBadRecords) {
  LibcaerCmpDecoder decoder({.first_offset = 10});
  decoder.begin(0);
  Bytes bytes;
  for (int code = 0; code < 16; ++code) append(bytes, cmp(code, 1));
  EXPECT_EQ(decode(decoder, bytes).size(), 2u);
  EXPECT_EQ(decoder.bad_records(), 10u);
  EXPECT_EQ(decoder.noted().front(), 10u + 6 * 2);
}

// The records of a message as ROS writes them: each field at a multiple of its size in CDR.
Bytes dvs(const Events& events, DvsRecords::Layout layout) {
  Bytes bytes;
  const auto field = [&](auto value) {
    while (layout == DvsRecords::Layout::cdr && bytes.size() % sizeof value != 0) {
      bytes.push_back(std::byte{0xee});
    }
    append(bytes, value);
  };
  for (const Event& event : events) {
    field(event.x);
    field(event.y);
    field(static_cast<std::uint32_t>(event.t / 1'000'000));
    field(static_cast<std::uint32_t>(event.t % 1'000'000 * 1000 + 999));
    field(static_cast<std::uint8_t>(event.p));
  }
  return bytes;
}

Events random_events(std::size_t count) {
  const CounterRandom random(8);
  Events events;
  for (std::size_t i = 0; i < count; ++i) {
    events.push_back({static_cast<std::uint16_t>(random(4 * i)),
                      static_cast<std::uint16_t>(random(4 * i + 1)),
                      static_cast<std::int16_t>(random(4 * i + 2) & 1),
                      static_cast<std::int64_t>(random(4 * i + 3) % 4'294'967'296'000'000)});
  }
  return events;
}

TEST(DvsRecords, DecodesBothLayoutsInPieces) {
  const Events truth = random_events(100);
  for (const auto layout : {DvsRecords::Layout::ros1, DvsRecords::Layout::cdr}) {
    const Bytes bytes = dvs(truth, layout);
    const DvsRecords records(bytes, layout);
    ASSERT_EQ(records.whole(), truth.size());
    for (std::size_t piece = 1; piece <= truth.size(); ++piece) {
      Events events(truth.size());
      for (std::size_t at = 0; at < truth.size(); at += piece) {
        const std::size_t count = std::min(piece, truth.size() - at);
        records.decode(at, std::span(events).subspan(at, count));
      }
      ASSERT_EQ(events, truth) << piece;
    }
  }
}

TEST(DvsRecords, CountsTheRecordsThatAreWhole) {
  for (const auto layout : {DvsRecords::Layout::ros1, DvsRecords::Layout::cdr}) {
    const Bytes bytes = dvs(random_events(5), layout);
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      std::size_t whole = 0;
      while (dvs(random_events(whole + 1), layout).size() <= size) ++whole;
      ASSERT_EQ(DvsRecords(std::span(bytes).first(size), layout).whole(), whole) << size;
    }
  }
}

}  // namespace
}  // namespace asap::packets_test
