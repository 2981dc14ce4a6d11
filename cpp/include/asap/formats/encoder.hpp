// Encoder: events as the bytes of a file: Prophesee EVT3, Event Stream, or csv.
//
// One thread. header() comes first, then what encode() writes, call after call. Timestamps stay as
// they are: EVT3 and Event Stream count from 0, and bridge a long gap by records that only advance
// the time; encode() writes as many of them as there is room for. O(events + bytes). No allocation
// but in header() and for an error.
//
//   Encoder encoder{{.width = 1280, .height = 720}};
//   write(encoder.header());
//   std::array<std::byte, 4096> room;
//   const Progress progress = encoder.encode(events, std::span(room));
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>

#include "asap/core/event.hpp"
#include "asap/formats/decoder.hpp"

namespace asap::inline v0_1 {

enum class Encoding : std::uint8_t { evt3, event_stream, csv };

struct EncoderConfig {
  Encoding encoding = Encoding::evt3;
  int width = 0;  // px; 0: not known, so that the header does not state it
  int height = 0;
};

class Encoder {
 public:
  static constexpr std::size_t kMaxPerEvent = 48;  // bytes; with less room nothing is written

  // Throws std::invalid_argument for an Event Stream without width and height.
  explicit Encoder(const EncoderConfig& config = {});

  // What the file begins with.
  std::string header() const;

  // Encodes from the front of `events` until one of them ends. Returns the bytes written and the
  // events consumed. Throws std::invalid_argument that names the event if the format cannot hold
  // it, for example because its timestamp goes back. The bytes of that call are then lost.
  Progress encode(std::span<const Event> events, std::span<std::byte> bytes);

  // Encodes an external trigger, which is no older than the last event; its id is below 16. For
  // EVT3. Returns no trigger where the room has ended before it: call again.
  Progress encode(const Trigger& trigger, std::span<std::byte> bytes);

  // Begins anew, with events from this time on: the bytes count from it.
  void reset(std::int64_t first_us) noexcept { state_ = {.t = first_us, .last_t = first_us}; }

  // The next event states its time and row again: what follows can be read without what came
  // before, but for the epoch of the time. For EVT3.
  void restate() noexcept {
    state_.started = false;
    state_.y = State{}.y;
  }

  // What an encoder remembers between two calls.
  struct State {
    std::int64_t t = 0;  // us, as a reader knows it from the bytes so far
    std::int64_t last_t = std::numeric_limits<std::int64_t>::min();  // timestamp of the last event
    std::uint64_t events = 0;
    std::uint32_t y = 1u << 16;  // the row that stands in the bytes; none yet
    bool started = false;        // a time stands in the bytes
  };

 private:
  template <class Format>
  Progress encode_as(std::span<const Event> events, std::span<std::byte> bytes);

  EncoderConfig config_;
  State state_;
};

}  // namespace asap::inline v0_1
