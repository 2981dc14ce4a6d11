// What every decoder offers alike, fed with random bytes.
#include "asap/formats/decoder.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <type_traits>
#include <vector>

#include "asap/formats/aedat.hpp"
#include "asap/formats/atis.hpp"
#include "asap/formats/packets.hpp"
#include "asap/formats/prophesee.hpp"
#include "asap/formats/text.hpp"
#include "formats/decoding.hpp"

namespace asap::decoder_test {
namespace {

using decoding::Bytes;
using decoding::Events;

template <class Decoder>
Decoder made() {
  if constexpr (std::is_same_v<Decoder, EventStreamDecoder>) {
    return Decoder({.version = 1, .height = 240});  // its shortest events
  } else {
    return Decoder();
  }
}

// Words with a type in their upper bits are mostly events, times and vectors; text is digits.
template <class Decoder>
Bytes some_bytes() {
  Bytes bytes;
  const CounterRandom random(5);
  if constexpr (std::is_same_v<Decoder, TextDecoder>) {
    for (std::uint64_t i = 0; i < 5000; ++i) decoding::append(bytes, "1,2,3,1\n");
  } else if constexpr (std::is_same_v<Decoder, Aedat3Decoder>) {
    constexpr std::uint64_t kEvents = 5000;
    for (const std::uint64_t field :
         {std::uint64_t{1} << 16 | 1, std::uint64_t{8}, std::uint64_t{4}, std::uint64_t{0}, kEvents,
          kEvents, kEvents}) {
      decoding::append_little(bytes, field, 4);
    }
    for (std::uint64_t i = 0; i < kEvents; ++i) decoding::append_little(bytes, i << 32 | 7, 8);
  } else {
    for (std::uint64_t i = 0; i < 20'000; ++i) decoding::append_little(bytes, random(i), 2);
  }
  return bytes;
}

template <class Decoder>
struct EveryDecoder : testing::Test {};

using Decoders = testing::Types<TextDecoder, Evt2Decoder, Evt21Decoder, Evt3Decoder, DatDecoder,
                                Aedat2Decoder, Aedat3Decoder, EventStreamDecoder, Atis40Decoder,
                                MonoDecoder, LibcaerDecoder, LibcaerCmpDecoder>;
TYPED_TEST_SUITE(EveryDecoder, Decoders);

// A vector was taken for a span of 0 places once, so that nothing was decoded.
TYPED_TEST(EveryDecoder, AppendsToAVectorWhatItWritesToASpan) {
  const Bytes bytes = some_bytes<TypeParam>();
  Events expected(500'000);
  TypeParam once = made<TypeParam>();
  const Progress progress = once.decode(bytes, std::span(expected));
  ASSERT_EQ(progress.bytes, bytes.size());
  ASSERT_GT(progress.events, 500u);
  expected.resize(progress.events);
  Events appended;
  TypeParam cut = made<TypeParam>();
  cut.decode(std::span(bytes).first(1001), appended);
  cut.decode(std::span(bytes).subspan(1001), appended);
  EXPECT_EQ(appended, expected);
}

TYPED_TEST(EveryDecoder, TellsTheRoomThatIsEnough) {
  const Bytes bytes = some_bytes<TypeParam>();
  TypeParam decoder = made<TypeParam>();
  std::size_t begin = 0;
  for (std::size_t piece = 1; begin + piece <= bytes.size(); begin += piece, piece += 3) {
    Events events(decoder.room_for(piece));
    ASSERT_EQ(decoder.decode(std::span(bytes).subspan(begin, piece), std::span(events)).bytes,
              piece)
        << begin;
  }
}

}  // namespace
}  // namespace asap::decoder_test
