#include "asap/formats/atis.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

#include "formats/decoding.hpp"

namespace asap::event_stream_test {
namespace {

using namespace decoding;

constexpr std::uint16_t kHeight = 260;

EventStreamDecoder decoder_of(int version) {
  return EventStreamDecoder({.version = version, .height = kHeight});
}

Bytes record2(unsigned step, unsigned p, unsigned x, unsigned y) {
  Bytes bytes;
  append(bytes, {step << 1 | p});
  append_little(bytes, x, 2);
  append_little(bytes, y, 2);
  return bytes;
}

Bytes record1(unsigned step, unsigned p, unsigned x, unsigned y) {
  Bytes bytes;
  append_little(bytes, step | x << 4 | y << 14 | p << 23, 3);
  return bytes;
}

Bytes joined(std::initializer_list<Bytes> parts) {
  Bytes bytes;
  for (const Bytes& part : parts) bytes.insert(bytes.end(), part.begin(), part.end());
  return bytes;
}

TEST(EventStreamDecoder, DecodesVersion2) {
  Bytes bytes = joined({record2(3, 1, 345, 259), record2(0, 0, 0xffff, 0xfffe)});
  append(bytes, {0xff, 0xff, 0xfe});
  bytes = joined({bytes, record2(126, 1, 1, 2)});
  EXPECT_EQ(events_of(decoder_of(2), bytes),
            (Events{{345, 0, 1, 3}, {0xffff, 261, 0, 3}, {1, 257, 1, 3 + 254 + 126}}));
}

TEST(EventStreamDecoder, DecodesVersion1) {
  Bytes bytes = joined({record1(3, 1, 303, 239), record1(14, 0, 1023, 511)});
  append(bytes, {0x2f, 0x0f, 0xff});  // 2 x 15 us, padding, 15 x 15 us
  bytes = joined({bytes, record1(1, 1, 5, 6)});
  EXPECT_EQ(events_of(EventStreamDecoder({.version = 1, .height = 240}), bytes),
            (Events{{303, 0, 1, 3}, {1023, 0xfef0, 0, 17}, {5, 233, 1, 17 + 30 + 225 + 1}}));
}

TEST(EventStreamDecoder, ConsumesWhatNeedsNoRoom) {
  Bytes bytes = record2(3, 1, 345, 259);
  append(bytes, {0xff, 0xfe, 0xff});
  EventStreamDecoder decoder = decoder_of(2);
  Events one(1);
  EXPECT_EQ(decoder.decode(bytes, std::span(one)).bytes, bytes.size());
  const Bytes next = record2(1, 0, 7, 8);
  EXPECT_EQ(decoder.decode(next, {}).bytes, 0u);
  EXPECT_EQ(decoder.decode(std::span(next).first(2), {}).bytes, 2u);
  EXPECT_EQ(decoder.unfinished(), 2u);
  EXPECT_EQ(decoder.decode(std::span(next).subspan(2), std::span(one)).events, 1u);
  EXPECT_EQ(one[0], (Event{7, 251, 0, 3 + 254 + 1}));
}

TEST(EventStreamDecoder, RefusesUnknownVersionsAndNoHeight) {
  EXPECT_THROW(decoder_of(3), std::invalid_argument);
  EXPECT_THROW(EventStreamDecoder({.version = 1}), std::invalid_argument);
}

Bytes header(std::initializer_list<unsigned> rest) {
  Bytes bytes;
  append(bytes, "Event Stream");
  append(bytes, rest);
  return bytes;
}

TEST(EventStreamHeader, HasTheSizeOfTheSensorInVersion2) {
  const Bytes bytes = header({2, 0, 0, 1, 0x5a, 1, 4, 1, 0});
  const auto read = read_event_stream_header(bytes);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->size, 20u);
  EXPECT_EQ(read->version, 2);
  EXPECT_EQ(read->type, EventStreamHeader::Type::dvs);
  EXPECT_EQ(read->width, 346);
  EXPECT_EQ(read->height, 260);
  for (std::size_t size = 0; size < 20; ++size) {
    EXPECT_FALSE(read_event_stream_header(std::span(bytes).first(size))) << size;
  }
}

TEST(EventStreamHeader, HasNoSizeInVersion1) {
  const auto read = read_event_stream_header(header({1, 0, 0}));
  ASSERT_TRUE(read);
  EXPECT_EQ(read->size, 15u);
  EXPECT_EQ(read->version, 1);
  EXPECT_EQ(read->type, EventStreamHeader::Type::dvs);
  EXPECT_EQ(read->width, 0);
}

TEST(EventStreamHeader, TellsOtherTypesAndOtherFiles) {
  using Type = EventStreamHeader::Type;
  EXPECT_EQ(read_event_stream_header(header({2, 0, 0, 2, 1, 0, 1, 0}))->type, Type::atis);
  EXPECT_EQ(read_event_stream_header(header({2, 0, 0, 0}))->size, 16u);
  EXPECT_EQ(read_event_stream_header(header({2, 0, 0, 9}))->type, Type::unknown);
  EXPECT_EQ(read_event_stream_header(header({1, 0, 1}))->type, Type::atis);
  EXPECT_EQ(read_event_stream_header(header({1, 0, 200}))->type, Type::unknown);
  EXPECT_FALSE(read_event_stream_header(header({3, 0, 0, 1, 1, 0, 1, 0})));
  EXPECT_FALSE(read_event_stream_header(Bytes(100)));
}

}  // namespace
}  // namespace asap::event_stream_test
