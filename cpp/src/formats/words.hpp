// Words of fixed size from bytes that are cut anywhere, and events written as two words: the loop
// that the native decoders share. Whole words are decoded where they stand; only a cut one passes
// through a buffer. The source of a decoder instantiates its NativeDecoder.
//
// One thread. O(bytes), no allocation.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "asap/core/event.hpp"
#include "asap/formats/decoder.hpp"

namespace asap::inline v0_1 {

template <class Word>
Word swap_bytes(Word word) noexcept {
  Word swapped = 0;
  for (std::size_t i = 0; i < sizeof(Word); ++i) {
    swapped = static_cast<Word>((swapped << 8) | (word & 0xff));
    word = static_cast<Word>(word >> 8);
  }
  return swapped;
}

template <class Word>
Word load_little(const std::byte* at) noexcept {
  Word word;
  std::memcpy(&word, at, sizeof word);
  return std::endian::native == std::endian::little ? word : swap_bytes(word);
}

template <class Word>
Word load_big(const std::byte* at) noexcept {
  Word word;
  std::memcpy(&word, at, sizeof word);
  return std::endian::native == std::endian::big ? word : swap_bytes(word);
}

// Writes two words, where a compiler would make four stores of the fields. Each argument fits its
// field.
inline void write_event(Event* out, std::uint64_t x, std::uint64_t y, std::uint64_t p,
                        std::int64_t t) noexcept {
  if constexpr (std::endian::native == std::endian::little) {
    const std::uint64_t place = x | y << 16 | p << 32;
    auto* bytes = reinterpret_cast<std::byte*>(out);
    std::memcpy(bytes, &place, sizeof place);
    std::memcpy(bytes + sizeof place, &t, sizeof t);
  } else {
    *out = {static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y),
            static_cast<std::int16_t>(p), t};
  }
}

// The time in us whose lower bits are `low`: in the epoch of `last`, in the next one where it would
// fall by more than half of `range`, a power of two, or in the one before where it would rise by
// nearly all of it: a small step back over the wrap.
inline std::int64_t unwrapped(std::int64_t last, std::int64_t low, std::int64_t range) noexcept {
  const std::int64_t t = (last & -range) | low;
  if (last - t > range / 2) return t + range;
  return t - last > range - range / 1024 && last >= range ? t - range : t;
}

// Where a decoder writes to. Events beyond `event` are scratch until decode() returns.
struct Output {
  Event* event;
  Event* events_end;
  Trigger* trigger = nullptr;
  Trigger* triggers_end = nullptr;
  bool keeps_triggers = false;

  std::size_t room() const noexcept { return static_cast<std::size_t>(events_end - event); }

  bool has_room_for_a_trigger() const noexcept {
    return !keeps_triggers || trigger != triggers_end;
  }

  // False without room for a trigger that the caller wants.
  bool take(const Trigger& seen) noexcept {
    if (!has_room_for_a_trigger()) return false;
    if (keeps_triggers) *trigger++ = seen;
    return true;
  }

  // The progress of a call that began to write at `start` and consumed `bytes`.
  Progress since(const Output& start, std::size_t bytes) const noexcept {
    return {.bytes = bytes,
            .events = static_cast<std::size_t>(event - start.event),
            .triggers = static_cast<std::size_t>(trigger - start.trigger)};
  }
};

inline Output output_to(std::span<Event> events) noexcept {
  return {.event = events.data(), .events_end = events.data() + events.size()};
}

inline Output output_to(std::span<Event> events, std::span<Trigger> triggers) noexcept {
  return {.event = events.data(),
          .events_end = events.data() + events.size(),
          .trigger = triggers.data(),
          .triggers_end = triggers.data() + triggers.size(),
          .keeps_triggers = true};
}

// `decode(at, count)` decodes the words from `at`, at most `count`, and returns how many it used:
// fewer only without room for the next one. Returns the bytes consumed.
template <std::size_t kSize, class Decode>
std::size_t decode_whole_words(CutRecord<kSize>& cut, std::span<const std::byte> bytes,
                               Decode&& decode) noexcept {
  std::size_t used = 0;
  if (cut.size > 0) {
    used = std::min(kSize - cut.size, bytes.size());
    std::copy_n(bytes.data(), used, cut.bytes.data() + cut.size);
    if (cut.size + used < kSize) {
      cut.size += used;
      return used;
    }
    if (decode(cut.bytes.data(), 1) == 0) return 0;  // its bytes are fed once more
    cut.size = 0;
  }
  const std::size_t whole = (bytes.size() - used) / kSize;
  const std::size_t decoded = decode(bytes.data() + used, whole);
  used += decoded * kSize;
  if (decoded < whole) return used;
  cut.size = bytes.size() - used;
  std::copy_n(bytes.data() + used, cut.size, cut.bytes.data());
  return bytes.size();
}

template <class Decoder, class Config, std::size_t kRecord>
Progress NativeDecoder<Decoder, Config, kRecord>::decode(std::span<const std::byte> bytes,
                                                         std::span<Event> events) noexcept {
  return decode_to(output_to(events), bytes);
}

template <class Decoder, class Config, std::size_t kRecord>
Progress NativeDecoder<Decoder, Config, kRecord>::decode(std::span<const std::byte> bytes,
                                                         std::span<Event> events,
                                                         std::span<Trigger> triggers) noexcept {
  return decode_to(output_to(events, triggers), bytes);
}

template <class Decoder, class Config, std::size_t kRecord>
void NativeDecoder<Decoder, Config, kRecord>::decode(std::span<const std::byte> bytes,
                                                     std::vector<Event>& events) {
  std::array<Event, 256> block;  // on the stack: a vector would be zeroed first
  while (!bytes.empty()) {
    const Progress progress = decode(bytes, std::span(block));
    events.insert(events.end(), block.begin(),
                  block.begin() + static_cast<std::ptrdiff_t>(progress.events));
    bytes = bytes.subspan(progress.bytes);
  }
}

template <class Decoder, class Config, std::size_t kRecord>
Progress NativeDecoder<Decoder, Config, kRecord>::decode_to(
    Output out, std::span<const std::byte> bytes) noexcept {
  const Output start = out;
  auto& decoder = static_cast<Decoder&>(*this);
  if constexpr (requires { decoder.decode_bytes(bytes, out); }) {
    return out.since(start, decoder.decode_bytes(bytes, out));
  } else {
    const auto decode_words = [&](const std::byte* first, std::size_t count) {
      const std::size_t decoded = decoder.decode_words(first, count, out);
      offset_ += decoded * kRecord;
      return decoded;
    };
    return out.since(start, decode_whole_words(cut_, bytes, decode_words));
  }
}

}  // namespace asap::inline v0_1
