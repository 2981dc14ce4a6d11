// What every decoder offers alike, fed with random bytes.
#include "asap/formats/decoder.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <variant>
#include <vector>

#include "asap/formats/packets.hpp"
#include "asap/formats/text.hpp"
#include "formats/decoding.hpp"
#include "formats/opener.hpp"

namespace asap::decoder_test {
namespace {

using decoding::Bytes;
using decoding::Events;

template <class Decoder>
Decoder made() {
  if constexpr (std::is_same_v<Decoder, EventStreamDecoder>) {
    return Decoder({.version = 1, .height = 240});  // its shortest events
  } else if constexpr (std::is_same_v<Decoder, Evt21Decoder>) {
    return Decoder({.little_endian = true});
  } else {
    return Decoder();
  }
}

// Words of so many bytes whose upper four bits are one of these types; no types: any.
Bytes some_words(std::size_t count, int size, const std::vector<std::uint64_t>& types = {}) {
  Bytes bytes;
  const CounterRandom random(5);
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::uint64_t bits = random(2 * i);
    const std::uint64_t type =
        types.empty() ? random(2 * i + 1) : types[random(2 * i + 1) % types.size()];
    decoding::append_little(bytes, bits >> 8, size - 1);
    decoding::append_little(bytes, (bits & 15) | type << 4, 1);
  }
  return bytes;
}

template <class Decoder>
Bytes some_bytes(std::size_t count = 5000) {
  if constexpr (std::is_same_v<Decoder, TextDecoder>) {
    Bytes bytes;
    for (std::uint64_t i = 0; i < count; ++i) decoding::append(bytes, "1,2,3,1\n");
    return bytes;
  } else if constexpr (std::is_same_v<Decoder, Aedat3Decoder>) {
    constexpr std::uint64_t kPackets = 20;
    const std::uint64_t size = count / kPackets;
    Bytes bytes;
    for (std::uint64_t packet = 0; packet < kPackets; ++packet) {
      const std::uint64_t type = packet % 5 == 2 ? 0 : packet % 5 == 3 ? 3 : 1;  // mostly polarity
      for (const std::uint64_t field : {std::uint64_t{1} << 16 | type, std::uint64_t{8},
                                        std::uint64_t{4}, packet / 4, size, size, size}) {
        decoding::append_little(bytes, field, 4);
      }
      for (std::uint64_t i = 0; i < size; ++i) {
        decoding::append_little(bytes, i << 32 | (type == 0 ? 5 : 7), 8);  // triggers, or events
      }
    }
    return bytes;
  } else if constexpr (std::is_same_v<Decoder, Evt2Decoder>) {
    return some_words(count, 4, {0, 0, 1, 1, 0, 1, 8, 10, 2});
  } else if constexpr (std::is_same_v<Decoder, Evt21Decoder>) {
    return some_words(count, 8, {0, 1, 0, 1, 8, 10, 2});
  } else if constexpr (std::is_same_v<Decoder, Evt3Decoder>) {
    return some_words(2 * count, 2, {0, 2, 2, 2, 3, 4, 5, 6, 6, 8, 10, 15});
  } else {
    return some_words(count, 8);
  }
}

template <class Decoder>
struct EveryDecoder : testing::Test {};

// Those of the list that recordings are opened with, of lines and of packets.
template <class... Decoders>
auto all_decoders(std::type_identity<std::variant<Decoders...>>)
    -> testing::Types<Decoders..., TextDecoder, MonoDecoder, LibcaerDecoder, LibcaerCmpDecoder>;

using Decoders = decltype(all_decoders(std::type_identity<RecordingDecoder>{}));
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

TYPED_TEST(EveryDecoder, CutsAndRoomMakeNoDifference) {
  if constexpr (!std::is_same_v<TypeParam, TextDecoder>) {  // which has neither triggers nor a size
    const Bytes bytes = some_bytes<TypeParam>(700);
    const auto decoder = made<TypeParam>();
    decoding::expect_cuts_and_room_make_no_difference(decoder, bytes);
    decoding::expect_truncation_gives_a_prefix(decoder, Bytes(bytes.begin(), bytes.begin() + 1200));
    decoding::expect_no_allocation(decoder, bytes);
  }
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
