// decode_records: the loop of every decoder whose records fit into 64 bits.
//
// A Format says what a record is; the loop cuts the bytes into records, whole ones straight from
// the input, and keeps the one that the input cuts in the caller's buffer. One thread, no
// allocation, O(bytes). A Format has:
//   kRecord          bytes of the longest record, at most 8
//   kBigEndian       the first byte of a record is the highest of `word`, else the lowest
//   size(word)       bytes of the record at the front of `word`; right even if later bytes are 0
//   is_event(word)   whether the record gives an event
//   waits(word)      whether the record has to wait for room for a trigger
//   take(word, to)   reads the record; writes an event, or what it likes, and returns 1 or 0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "asap/core/event.hpp"
#include "asap/formats/progress.hpp"
#include "formats/words.hpp"

namespace asap::records {

inline constexpr std::size_t kWord = sizeof(std::uint64_t);

// `size` bytes as a word, the rest zero.
template <bool kBigEndian>
std::uint64_t load(const std::byte* from, std::size_t size = kWord) noexcept {
  std::array<std::byte, kWord> bytes{};
  std::memcpy(bytes.data(), from, size);
  return kBigEndian ? load_big<std::uint64_t>(bytes.data())
                    : load_little<std::uint64_t>(bytes.data());
}

// Where triggers go: into `triggers`.
inline Output output_of(std::span<Trigger> triggers) noexcept {
  return {.event = nullptr,
          .events_end = nullptr,
          .trigger = triggers.data(),
          .triggers_end = triggers.data() + triggers.size(),
          .keeps_triggers = true};
}

inline bool has_room_for_a_trigger(const Output& out) noexcept {
  return !out.keeps_triggers || out.trigger != out.triggers_end;
}

template <class Format, std::size_t kCut>
Progress decode_records(Format& format, CutRecord<kCut>& cut, std::span<const std::byte> bytes,
                        std::span<Event> events) noexcept {
  static_assert(Format::kRecord <= kWord && Format::kRecord <= kCut);
  const std::byte* at = bytes.data();
  const std::byte* const end = at + bytes.size();
  Event* out = events.data();
  Event* const full = out + events.size();
  const auto progress = [&] {
    return Progress{static_cast<std::size_t>(at - bytes.data()),
                    static_cast<std::size_t>(out - events.data())};
  };
  const auto keep = [&](std::size_t size) {
    if (size > 0) std::memcpy(cut.bytes.data() + cut.size, at, size);
    cut.size += size;
    at += size;
  };

  const auto has_to_wait = [&](std::uint64_t word) {
    return (out == full && format.is_event(word)) || format.waits(word);
  };

  if (cut.size > 0) {
    const std::size_t whole = format.size(load<Format::kBigEndian>(cut.bytes.data(), cut.size));
    const std::size_t missing = whole - cut.size;
    if (missing > bytes.size()) {
      keep(bytes.size());
      return progress();
    }
    std::array<std::byte, kWord> record{};
    std::memcpy(record.data(), cut.bytes.data(), cut.size);
    std::memcpy(record.data() + cut.size, at, missing);
    const std::uint64_t word = load<Format::kBigEndian>(record.data());
    if (has_to_wait(word)) return progress();
    Event event;
    if (format.take(word, &event) > 0) *out++ = event;
    at += missing;
    cut.size = 0;
  }
  while (static_cast<std::size_t>(end - at) >= kWord && out != full) {
    const std::uint64_t word = load<Format::kBigEndian>(at);
    if (format.waits(word)) break;
    out += format.take(word, out);
    at += format.size(word);
  }
  // The last few bytes; and without room, what needs none.
  while (at != end) {
    const std::size_t left = static_cast<std::size_t>(end - at);
    const std::uint64_t word = load<Format::kBigEndian>(at, std::min(left, kWord));
    const std::size_t size = format.size(word);
    if (left < size) {
      keep(left);
      break;
    }
    if (has_to_wait(word)) break;
    Event event;
    if (format.take(word, &event) > 0) *out++ = event;
    at += size;
  }
  return progress();
}

}  // namespace asap::records
