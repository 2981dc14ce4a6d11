// All that a native decoder makes of some bytes, and that it is the same however they are cut and
// however little room there is.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "asap/core/event.hpp"
#include "asap/core/random.hpp"
#include "asap/formats/progress.hpp"

namespace asap::decoding {

using Bytes = std::vector<std::byte>;
using Events = std::vector<Event>;
using Triggers = std::vector<Trigger>;
using Offsets = std::vector<std::uint64_t>;

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

template <class Decoder>
Progress decode_some(Decoder& decoder, std::span<const std::byte> bytes, std::span<Event> events,
                     std::span<Trigger> triggers) {
  if constexpr (requires { decoder.decode(bytes, events, triggers); }) {
    return decoder.decode(bytes, events, triggers);
  } else {
    return decoder.decode(bytes, events);
  }
}

// Every call with room comes after one without.
template <class Decoder>
void feed(Decoder& decoder, std::span<const std::byte> bytes, std::size_t room, Decoded& decoded) {
  Events events(room);
  Triggers triggers(1);
  const auto append = [](auto& from, std::size_t count, auto& to) {
    to.insert(to.end(), from.begin(), from.begin() + static_cast<std::ptrdiff_t>(count));
  };
  while (!bytes.empty()) {
    const Progress none = decode_some(decoder, bytes, {}, {});
    ASSERT_TRUE(none.events == 0 && none.triggers == 0);
    bytes = bytes.subspan(none.bytes);
    if (bytes.empty()) return;
    const Progress progress = decode_some(decoder, bytes, events, triggers);
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
  if constexpr (requires { decoder.before_start(); }) decoded.before_start = decoder.before_start();
  return decoded;
}

template <class Decoder>
void expect_cuts_and_room_make_no_difference(const Decoder& decoder, const Bytes& bytes) {
  const Decoded whole = decode(decoder, bytes);
  EXPECT_GT(whole.events.size(), 500u);
  for (std::size_t piece = 1; piece < 40; ++piece) {
    const std::size_t room = Decoder::kMostPerRecord + piece % 5;
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

}  // namespace asap::decoding
