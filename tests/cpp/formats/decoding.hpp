// All that a native decoder makes of some bytes, and that it is the same however they are cut and
// however little room there is.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <string_view>
#include <vector>

#include "asap/core/event.hpp"
#include "asap/formats/decoder.hpp"
#include "core/random.hpp"
#include "support/allocation_counter.hpp"

namespace asap::decoding {

using Bytes = std::vector<std::byte>;
using Events = std::vector<Event>;
using Triggers = std::vector<Trigger>;
using Offsets = std::vector<std::uint64_t>;

inline void append(Bytes& bytes, std::initializer_list<unsigned> values) {
  for (const unsigned value : values) bytes.push_back(static_cast<std::byte>(value));
}

inline void append(Bytes& bytes, std::string_view text) {
  for (const char c : text) bytes.push_back(static_cast<std::byte>(c));
}

inline void append_little(Bytes& bytes, std::uint64_t value, int size) {
  for (int i = 0; i < size; ++i) bytes.push_back(static_cast<std::byte>(value >> 8 * i));
}

inline void append_big(Bytes& bytes, std::uint64_t value, int size) {
  for (int i = size - 1; i >= 0; --i) bytes.push_back(static_cast<std::byte>(value >> 8 * i));
}

// Little-endian.
template <class Word>
Bytes bytes_of(const std::vector<Word>& words) {
  Bytes bytes;
  for (const Word word : words) {
    for (std::size_t i = 0; i < sizeof word; ++i) {
      bytes.push_back(static_cast<std::byte>(word >> 8 * i & 0xff));
    }
  }
  return bytes;
}

struct Decoded {
  Events events;
  Triggers triggers;
  std::uint64_t bad_records = 0;
  std::uint64_t before_start = 0;
  Offsets noted;
  std::size_t unfinished = 0;

  friend bool operator==(const Decoded&, const Decoded&) = default;
};

// Every call with room comes after one without.
template <class Decoder>
void feed(Decoder& decoder, std::span<const std::byte> bytes, std::size_t room, Decoded& decoded) {
  Events events(room);
  Triggers triggers(1);
  const auto append = [](auto& from, std::size_t count, auto& to) {
    to.insert(to.end(), from.begin(), from.begin() + static_cast<std::ptrdiff_t>(count));
  };
  while (!bytes.empty()) {
    const Progress none = decoder.decode(bytes, {}, {});
    ASSERT_TRUE(none.events == 0 && none.triggers == 0);
    bytes = bytes.subspan(none.bytes);
    if (bytes.empty()) return;
    const Progress progress = decoder.decode(bytes, events, triggers);
    ASSERT_TRUE(progress.bytes > 0 || progress.events > 0 || progress.triggers > 0);
    bytes = bytes.subspan(progress.bytes);
    append(events, progress.events, decoded.events);
    append(triggers, progress.triggers, decoded.triggers);
  }
}

template <class Decoder>
Decoded decode(Decoder decoder, std::span<const std::byte> bytes,
               std::size_t piece = ~std::size_t{0}, std::size_t room = 4096) {
  Decoded decoded;
  while (!bytes.empty()) {
    const auto fed = bytes.first(std::min(piece, bytes.size()));
    bytes = bytes.subspan(fed.size());
    feed(decoder, fed, room, decoded);
  }
  decoded.bad_records = decoder.bad_records();
  decoded.noted = {decoder.noted().begin(), decoder.noted().end()};
  decoded.unfinished = decoder.unfinished();
  decoded.before_start = decoder.before_start();
  return decoded;
}

template <class Decoder>
Events events_of(const Decoder& decoder, std::span<const std::byte> bytes) {
  return decode(decoder, bytes).events;
}

template <class Decoder>
void expect_cuts_and_room_make_no_difference(const Decoder& decoder, const Bytes& bytes) {
  const Decoded whole = decode(decoder, bytes);
  EXPECT_GT(whole.events.size(), 100u);
  for (std::size_t piece = 1; piece < 40; ++piece) {
    const std::size_t room = Decoder::kMaxPerRecord + piece % 5;
    EXPECT_EQ(decode(decoder, bytes, piece, room), whole) << piece;
  }
  const auto cut_at = [&](std::size_t cut) {
    Decoder cut_once = decoder;
    Decoded decoded;
    feed(cut_once, std::span(bytes).first(cut), 4096, decoded);
    EXPECT_TRUE(std::equal(decoded.events.begin(), decoded.events.end(), whole.events.begin()));
    feed(cut_once, std::span(bytes).subspan(cut), 4096, decoded);
    EXPECT_EQ(decoded.events, whole.events) << cut;
  };
  for (std::size_t cut = 0; cut <= std::min<std::size_t>(bytes.size(), 4096); ++cut) cut_at(cut);
  const CounterRandom random(8);
  for (std::uint64_t i = 0; i < 1000; ++i) cut_at(random(i) % bytes.size());
}

// Truncated at every byte: a prefix of the events. What comes before the unfinished bytes holds no
// others, and ends with a record.
template <class Decoder>
void expect_truncation_gives_a_prefix(const Decoder& decoder, const Bytes& bytes) {
  const Events truth = events_of(decoder, bytes);
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const Decoded cut = decode(decoder, std::span(bytes).first(size));
    ASSERT_LE(cut.events.size(), truth.size());
    ASSERT_TRUE(std::equal(cut.events.begin(), cut.events.end(), truth.begin())) << size;
    ASSERT_LE(cut.unfinished, size);
    const Decoded whole = decode(decoder, std::span(bytes).first(size - cut.unfinished));
    ASSERT_LE(whole.events.size(), cut.events.size());
    ASSERT_EQ(whole.unfinished, 0u) << size;
  }
}

// And reset() leaves nothing behind.
template <class Decoder>
void expect_no_allocation(Decoder decoder, const Bytes& bytes) {
  const Decoded whole = decode(decoder, bytes);
  Events events(bytes.size() * Decoder::kMaxPerRecord);
  const std::size_t before = test::allocations();
  static_cast<void>(decoder.decode(bytes, std::span(events)));
  decoder.reset();
  EXPECT_EQ(test::allocations(), before);
  EXPECT_EQ(decode(decoder, bytes), whole);
}

}  // namespace asap::decoding
