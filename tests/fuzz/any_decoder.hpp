// What holds for every decoder of bytes: it makes progress, stays within its room, and how the
// bytes are cut and how much room there is makes no difference.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "asap/core/event.hpp"
#include "asap/formats/decoder.hpp"
#include "bytes.hpp"

namespace asap::fuzz {

struct Decoded {
  std::vector<Event> events;
  std::vector<Trigger> triggers;

  friend bool operator==(const Decoded&, const Decoded&) = default;
};

// Arrays of the exact size, so that the sanitizer sees a write beyond them.
struct Room {
  Room(std::size_t event_count, std::size_t trigger_count)
      : events(event_count), triggers(trigger_count) {}

  std::vector<Event> events;
  std::vector<Trigger> triggers;
};

// Made once: memory under a sanitizer is dear.
inline Room& ample_room() {
  static Room room(256, 64);
  return room;
}

template <class Decoder>
Decoded decode_in_pieces(Decoder& decoder, std::span<const std::byte> bytes, std::size_t piece,
                         Room& room) {
  Decoded all;
  auto& [events, triggers] = room;
  while (!bytes.empty()) {
    auto fed = bytes.first(std::min(piece, bytes.size()));
    bytes = bytes.subspan(fed.size());
    while (!fed.empty()) {
      const Progress done = decoder.decode(fed, events, triggers);
      check(done.bytes <= fed.size() && done.events <= events.size() &&
            done.triggers <= triggers.size());
      check(done.bytes + done.events + done.triggers > 0);
      all.events.insert(all.events.end(), events.begin(),
                        events.begin() + static_cast<std::ptrdiff_t>(done.events));
      all.triggers.insert(all.triggers.end(), triggers.begin(),
                          triggers.begin() + static_cast<std::ptrdiff_t>(done.triggers));
      fed = fed.subspan(done.bytes);
    }
  }
  return all;
}

template <class Decoder>
bool same_books(const Decoder& a, const Decoder& b) {
  return a.unfinished() == b.unfinished() && a.bad_records() == b.bad_records() &&
         std::ranges::equal(a.noted(), b.noted()) && a.triggers() == b.triggers() &&
         a.before_start() == b.before_start();
}

template <class Decoder>
void check_decoder(const Decoder& fresh, Bytes& bytes) {
  const std::size_t piece = 1 + bytes.below(64);
  Room little(Decoder::kMaxPerRecord + bytes.below(16), 1 + bytes.below(3));
  Room& ample = ample_room();
  const std::span<const std::byte> input = std::as_bytes(bytes.rest());
  Decoder whole = fresh, cut = fresh;
  const Decoded decoded = decode_in_pieces(whole, input, input.size(), ample);
  check(decode_in_pieces(cut, input, piece, little) == decoded);
  check(same_books(whole, cut));
  check(std::ranges::all_of(whole.noted(), [&](auto at) { return at < input.size(); }));
  whole.reset();
  check(decode_in_pieces(whole, input, input.size(), ample) == decoded);
}

}  // namespace asap::fuzz
