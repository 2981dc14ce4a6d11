// decode_records: the loop of every decoder whose records fit into 64 bits.
//
// A Format says what a record is; the loop cuts the bytes into records, whole ones straight from
// the input, and keeps the one that the input cuts in the caller's buffer. One thread, no
// allocation, O(bytes). A Format has:
//   kRecord          bytes of the longest record, at most 8
//   kBigEndian       the first byte of a record is the highest of `word`, else the lowest
//   size(word)       bytes of the record at the front of `word`; right even if later bytes are 0
//   is_event(word)   whether the record gives an event
//   waits(word, out) whether the record has to wait for room for a trigger
//   take(word, to, out)
//                    reads the record; writes an event to `to`, or what it likes, and returns 1 or
//                    0; triggers go to `out`
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "asap/core/event.hpp"
#include "asap/formats/decoder.hpp"
#include "formats/words.hpp"

namespace asap::inline v0_1::records {

inline constexpr std::size_t kWord = sizeof(std::uint64_t);

// `size` bytes as a word, the rest zero.
template <bool kBigEndian>
std::uint64_t load(const std::byte* from, std::size_t size = kWord) noexcept {
  std::array<std::byte, kWord> bytes{};
  std::memcpy(bytes.data(), from, size);
  return kBigEndian ? load_big<std::uint64_t>(bytes.data())
                    : load_little<std::uint64_t>(bytes.data());
}

// Returns how many bytes it consumed.
template <class Format, std::size_t kCut>
std::size_t decode_records(Format& format, CutRecord<kCut>& cut, std::span<const std::byte> bytes,
                           Output& out) noexcept {
  static_assert(Format::kRecord <= kWord && Format::kRecord <= kCut);
  const std::byte* at = bytes.data();
  const std::byte* const end = at + bytes.size();
  Event* event = out.event;
  Event* const full = out.events_end;
  const auto consumed = [&] {
    out.event = event;
    return static_cast<std::size_t>(at - bytes.data());
  };
  const auto keep = [&](std::size_t size) {
    if (size > 0) std::memcpy(cut.bytes.data() + cut.size, at, size);
    cut.size += size;
    at += size;
  };
  // False without room.
  const auto take_one = [&](std::uint64_t word) {
    if ((event == full && format.is_event(word)) || format.waits(word, out)) return false;
    Event scratch;
    if (format.take(word, &scratch, out) > 0) *event++ = scratch;
    return true;
  };

  if (cut.size > 0) {
    const std::size_t whole = format.size(load<Format::kBigEndian>(cut.bytes.data(), cut.size));
    const std::size_t missing = whole - cut.size;
    if (missing > bytes.size()) {
      keep(bytes.size());
      return consumed();
    }
    std::array<std::byte, kWord> record{};
    std::memcpy(record.data(), cut.bytes.data(), cut.size);
    std::memcpy(record.data() + cut.size, at, missing);
    if (!take_one(load<Format::kBigEndian>(record.data()))) return consumed();
    at += missing;
    cut.size = 0;
  }
  while (static_cast<std::size_t>(end - at) >= kWord && event != full) {
    const std::uint64_t word = load<Format::kBigEndian>(at);
    if (format.waits(word, out)) break;
    event += format.take(word, event, out);
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
    if (!take_one(word)) break;
    at += size;
  }
  return consumed();
}

}  // namespace asap::inline v0_1::records
