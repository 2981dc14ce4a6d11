// What the tests of all decoders of bytes need: feeding them whole, in pieces, with little room.
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
#include "asap/core/random.hpp"
#include "asap/formats/progress.hpp"
#include "support/allocation_counter.hpp"

namespace asap::test {

using Bytes = std::vector<std::byte>;
using Events = std::vector<Event>;
using Triggers = std::vector<Trigger>;

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

template <class Decoder>
concept GivesTriggers = requires(Decoder decoder, Events events, Triggers triggers) {
  decoder.decode(std::span<const std::byte>{}, events, triggers);
};

// Feeds all of `bytes`, giving room for `room` events and one trigger at a time.
template <class Decoder>
void feed(Decoder& decoder, std::span<const std::byte> bytes, std::size_t room, Events& to,
          Triggers* triggers_to = nullptr) {
  Events events(room);
  Triggers triggers(1);
  while (!bytes.empty()) {
    Progress done;
    if constexpr (GivesTriggers<Decoder>) {
      done = decoder.decode(bytes, events, triggers);
    } else {
      done = decoder.decode(bytes, events);
    }
    ASSERT_LE(done.bytes, bytes.size());
    ASSERT_LE(done.events, room);
    ASSERT_LE(done.triggers, 1u);
    ASSERT_GT(done.bytes + done.events + done.triggers, 0u) << "no progress";
    to.insert(to.end(), events.begin(), events.begin() + static_cast<std::ptrdiff_t>(done.events));
    if (triggers_to != nullptr && done.triggers > 0) triggers_to->push_back(triggers[0]);
    bytes = bytes.subspan(done.bytes);
  }
}

template <class Decoder>
Events decode_whole(Decoder decoder, std::span<const std::byte> bytes) {
  Events events;
  feed(decoder, bytes, bytes.size() + 1, events);
  return events;
}

template <class Decoder>
void expect_same_books(const Decoder& a, const Decoder& b) {
  EXPECT_EQ(a.unfinished(), b.unfinished());
  EXPECT_EQ(a.bad_records(), b.bad_records());
  EXPECT_EQ(a.triggers(), b.triggers());
  EXPECT_TRUE(std::ranges::equal(a.noted(), b.noted()));
}

// Cut once at every place, cut into pieces of every small size, with room for few events: the
// events and the books are those of the whole. No allocation.
template <class Decoder>
void expect_cuts_make_no_difference(const Decoder& fresh, const Bytes& bytes) {
  Decoder whole = fresh;
  Events truth;
  Triggers true_triggers;
  feed(whole, bytes, bytes.size() + 1, truth, &true_triggers);
  EXPECT_EQ(whole.triggers(), true_triggers.size());
  const std::span<const std::byte> all = bytes;
  for (std::size_t at = 0; at <= std::min<std::size_t>(bytes.size(), 4096); ++at) {
    Decoder decoder = fresh;
    Events events;
    feed(decoder, all.first(at), 64, events);
    feed(decoder, all.subspan(at), bytes.size() + 1, events);
    ASSERT_EQ(events, truth) << "cut at " << at;
    expect_same_books(decoder, whole);
  }
  for (std::size_t piece = 1; piece <= 40; ++piece) {
    Decoder decoder = fresh;
    Events events;
    Triggers triggers;
    for (std::size_t at = 0; at < bytes.size(); at += piece) {
      const auto fed = all.subspan(at, std::min(piece, bytes.size() - at));
      feed(decoder, fed, 1 + piece % 5, events, &triggers);
    }
    ASSERT_EQ(events, truth) << "pieces of " << piece;
    ASSERT_EQ(triggers, true_triggers) << "pieces of " << piece;
    expect_same_books(decoder, whole);
  }
  const CounterRandom random(20);
  for (std::size_t round = 0; round < 1000; ++round) {
    Decoder decoder = fresh;
    Events events;
    const std::size_t at = random(round) % (bytes.size() + 1);
    feed(decoder, all.first(at), 7, events);
    feed(decoder, all.subspan(at), bytes.size() + 1, events);
    ASSERT_EQ(events, truth) << "cut at " << at;
  }
  Decoder decoder = fresh;
  Events room(bytes.size() + 1);
  const std::size_t before = allocations();
  decoder.decode(all, room);
  decoder.reset();
  EXPECT_EQ(allocations(), before);
  EXPECT_EQ(decode_whole(decoder, bytes), truth) << "after reset";
}

// Truncated at every byte: a prefix of the events, and what is left over begins no later than the
// first record that is missing.
template <class Decoder>
void expect_truncation_gives_a_prefix(const Decoder& fresh, const Bytes& bytes) {
  const Events truth = decode_whole(fresh, bytes);
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    Decoder decoder = fresh;
    Events events;
    feed(decoder, std::span(bytes).first(size), size + 1, events);
    ASSERT_LE(events.size(), truth.size());
    ASSERT_TRUE(std::equal(events.begin(), events.end(), truth.begin())) << size;
    ASSERT_LE(decoder.unfinished(), size);
    // The bytes before the offset that is reported hold no more than these events.
    Decoder to_offset = fresh;
    Events before;
    feed(to_offset, std::span(bytes).first(size - decoder.unfinished()), size + 1, before);
    ASSERT_LE(before.size(), events.size());
    ASSERT_EQ(to_offset.unfinished(), 0u) << size;
  }
}

}  // namespace asap::test
