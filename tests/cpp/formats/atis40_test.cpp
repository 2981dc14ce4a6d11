#include "asap/formats/atis.hpp"

#include <gtest/gtest.h>

#include "formats/decoding.hpp"

namespace asap::atis40_test {
namespace {

using namespace decoding;

void append_record(Bytes& bytes, unsigned x, unsigned y, unsigned p, unsigned t) {
  append_big(bytes, std::uint64_t{x} << 32 | y << 24 | p << 23 | t, 5);
}

TEST(Atis40Decoder, DecodesEveryField) {
  Bytes bytes;
  append_record(bytes, 255, 239, 1, 0x7f'ffff);
  append_record(bytes, 3, 4, 0, 0);
  EXPECT_EQ(events_of(Atis40Decoder(), bytes), (Events{{255, 239, 1, 8'388'607}, {3, 4, 0, 0}}));
}

TEST(Atis40Decoder, AddsWhatRow240Marks) {
  Bytes bytes;
  append_record(bytes, 1, 2, 1, 8000);
  append_record(bytes, 9, 240, 1, 77);
  append_record(bytes, 9, 240, 0, 0);
  append_record(bytes, 3, 4, 0, 5);
  EXPECT_EQ(events_of(Atis40Decoder(), bytes), (Events{{1, 2, 1, 8000}, {3, 4, 0, 16'389}}));
  EXPECT_EQ(events_of(Atis40Decoder({.marks = false}), bytes),
            (Events{{1, 2, 1, 8000}, {9, 240, 1, 77}, {9, 240, 0, 0}, {3, 4, 0, 5}}));
}

}  // namespace
}  // namespace asap::atis40_test
