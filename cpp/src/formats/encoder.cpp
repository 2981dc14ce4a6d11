#include "asap/formats/encoder.hpp"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstring>
#include <string_view>

#include "core/check.hpp"
#include "formats/words.hpp"

namespace asap::inline v0_1 {

namespace {

using State = Encoder::State;

template <class Word>
std::byte* put_little(std::byte* to, Word word) noexcept {
  if constexpr (std::endian::native == std::endian::big) word = swap_bytes(word);
  std::memcpy(to, &word, sizeof word);
  return to + sizeof word;
}

std::uint32_t is_on(const Event& event) noexcept { return event.p > 0 ? 1 : 0; }

// A format has limits and functions. put() writes an event. Where the bytes count time from event
// to event, it follows() state.t, to which mark() has advanced it, step by step towards the event's
// time: a gap of kMaxGap is worth its bytes. kMaxAddress has no zero bit below its ones. kRowsUp:
// row 0 is the bottom one. The layouts stand in the decoders' headers.

struct Limits {
  static constexpr std::uint32_t kMaxAddress = std::numeric_limits<std::uint16_t>::max();
  static constexpr bool kRowsUp = false;
  static constexpr std::int64_t kMinTime = 0;
  static constexpr std::int64_t kMaxTime = std::numeric_limits<std::int64_t>::max();
};

template <class Format>
concept CountsTime = requires { Format::kMaxGap; };

struct Evt3Format : Limits {
  static constexpr std::string_view kName = "EVT3";
  static constexpr std::uint32_t kMaxAddress = 2047;
  static constexpr std::int64_t kReach = std::int64_t{1} << 22;   // readers unwrap 2^24 us
  static constexpr std::int64_t kMaxGap = std::int64_t{1} << 40;  // 12.7 days: 1 MB of marks

  static bool follows(const State& state, std::int64_t t) noexcept {
    return state.started && (t ^ state.t) >> 12 == 0;
  }

  static std::byte* put(State& state, const Event& event, std::byte* to) noexcept {
    // Each word is written, and only those that say something new are kept: no branch to guess.
    put_word(to, kTimeLow, event.t & 0xfff);
    to += event.t != state.t ? kWord : 0;
    put_word(to, kAddrY, event.y);
    to += event.y != state.y ? kWord : 0;
    state.t = event.t;
    state.y = event.y;
    return put_word(to, kAddrX, is_on(event) << 11 | event.x);
  }

  static std::byte* put(State& state, const Trigger& trigger, std::byte* to) noexcept {
    to = put_time(state, trigger.t, to);
    return put_word(to, kTrigger, trigger.id << 8 | trigger.value);
  }

  static std::byte* mark(State& state, std::int64_t t, std::byte* to) noexcept {
    return put_time(state, std::min(t, state.t + kReach), to);
  }

 private:
  static constexpr std::uint32_t kAddrY = 0, kAddrX = 2, kTimeLow = 6, kTimeHigh = 8, kTrigger = 10;
  static constexpr std::ptrdiff_t kWord = 2;  // bytes

  static std::byte* put_word(std::byte* to, std::uint32_t type, std::int64_t payload) noexcept {
    return put_little(to, static_cast<std::uint16_t>(type << 12 | payload));
  }

  static std::byte* put_time(State& state, std::int64_t t, std::byte* to) noexcept {
    state.started = true;
    state.t = t;
    to = put_word(to, kTimeHigh, t >> 12 & 0xfff);
    return put_word(to, kTimeLow, t & 0xfff);
  }
};

struct EventStreamFormat : Limits {
  static constexpr std::string_view kName = "Event Stream";
  static constexpr bool kRowsUp = true;
  static constexpr std::int64_t kReach = 127;
  static constexpr std::int64_t kMaxGap = std::int64_t{1} << 32;  // 71 min: 34 MB of marks

  static std::byte* put(State& state, const Event& event, std::byte* to) noexcept {
    const auto elapsed = static_cast<std::uint32_t>(event.t - state.t);
    state.t = event.t;
    *to++ = static_cast<std::byte>(elapsed << 1 | is_on(event));
    return put_little(put_little(to, event.x), event.y);
  }

  static bool follows(const State& state, std::int64_t t) noexcept { return t - state.t < kReach; }

  static std::byte* mark(State& state, std::int64_t, std::byte* to) noexcept {
    state.t += kReach;
    *to++ = std::byte{0xff};
    return to;
  }
};

struct CsvFormat : Limits {
  static constexpr std::string_view kName = "csv";
  static constexpr std::int64_t kMinTime = std::numeric_limits<std::int64_t>::min();

  static std::byte* put(State&, const Event& event, std::byte* to) noexcept {
    to = put_number(to, event.t, ',');
    to = put_number(to, event.x, ',');
    to = put_number(to, event.y, ',');
    return put_number(to, is_on(event), '\n');
  }

 private:
  template <class Number>
  static std::byte* put_number(std::byte* to, Number number, char end) noexcept {
    constexpr int kLongest = std::numeric_limits<Number>::digits10 + 2;
    char* const text = reinterpret_cast<char*>(to);
    char* const last = std::to_chars(text, text + kLongest, number).ptr;
    *last = end;
    return to + (last - text) + 1;
  }
};

[[noreturn]] void refuse(std::string_view field, std::int64_t value, const State& state,
                         const std::string& fault) {
  throw_bad_value(field, std::to_string(value) + " (event " + std::to_string(state.events) + ")",
                  fault);
}

template <class Format>
[[noreturn]] void refuse(const State& state, const Event& event) {
  const std::string name(Format::kName);
  const std::string pixels = name + " holds pixels up to " + std::to_string(Format::kMaxAddress);
  if (event.x > Format::kMaxAddress) refuse("x", event.x, state, pixels);
  if (event.y > Format::kMaxAddress) refuse("y", event.y, state, pixels);
  if (event.t < state.last_t) {
    const auto back =
        static_cast<std::uint64_t>(state.last_t) - static_cast<std::uint64_t>(event.t);
    refuse("t", event.t, state,
           "goes back by " + std::to_string(back) + " us; sort the events, or drop this one");
  }
  refuse("t", event.t, state,
         name +
             " cannot hold this time; count from the first event (relative), or split the "
             "recording");
}

// What the next timestamp is at least.
template <class Format>
std::int64_t earliest(const State& state) noexcept {
  return state.last_t == State{}.last_t ? Format::kMinTime : state.last_t;
}

}  // namespace

Encoder::Encoder(const EncoderConfig& config) : config_(config) {
  const bool is_stated = config.encoding == Encoding::event_stream;
  const auto check = [&](const char* field, int side) {
    require(!is_stated || side > 0, field, side,
            "an Event Stream states its sensor: give the size in px");
    require(side >= 0 && side <= 65'535, field, side, "must be 0 (not known) to 65,535 px");
  };
  check("width", config.width);
  check("height", config.height);
}

std::string Encoder::header() const {
  const std::string width = std::to_string(config_.width), height = std::to_string(config_.height);
  const bool known = config_.width > 0 && config_.height > 0;
  switch (config_.encoding) {
    case Encoding::evt3:
      return "% evt 3.0\n% format EVT3" +
             (known
                  ? ";height=" + height + ";width=" + width + "\n% geometry " + width + "x" + height
                  : "") +
             "\n% end\n";
    case Encoding::event_stream: {
      std::string bytes("Event Stream\x02\0\0\x01", 16);
      for (const int side : {config_.width, config_.height}) {
        bytes += static_cast<char>(side & 0xff);
        bytes += static_cast<char>(side >> 8);
      }
      return bytes;
    }
    case Encoding::csv:
      return "t [us],x,y,p\n";
  }
  return {};
}

Progress Encoder::encode(std::span<const Event> events, std::span<std::byte> bytes) {
  switch (config_.encoding) {
    case Encoding::evt3:
      return encode_as<Evt3Format>(events, bytes);
    case Encoding::event_stream:
      return encode_as<EventStreamFormat>(events, bytes);
    case Encoding::csv:
      return encode_as<CsvFormat>(events, bytes);
  }
  return {};
}

Progress Encoder::encode(const Trigger& trigger, std::span<std::byte> bytes) {
  require(config_.encoding == Encoding::evt3, "encoding", static_cast<int>(config_.encoding),
          "only EVT3 holds triggers");
  require(trigger.id < 16, "id", int{trigger.id}, "EVT3 holds ids up to 15");
  require(trigger.t >= earliest<Evt3Format>(state_), "t", trigger.t,
          "must be 0 or more and not before the last event");
  Progress done;
  const auto room = [&] { return bytes.size() - done.bytes >= kMaxPerEvent; };
  const auto put = [&](std::byte* end) {
    done.bytes = static_cast<std::size_t>(end - bytes.data());
  };
  while (room() && trigger.t - state_.t >= Evt3Format::kReach) {
    put(Evt3Format::mark(state_, trigger.t, bytes.data() + done.bytes));
  }
  if (!room()) return done;
  put(Evt3Format::put(state_, trigger, bytes.data() + done.bytes));
  state_.last_t = trigger.t;
  done.triggers = 1;
  return done;
}

template <class Format>
Progress Encoder::encode_as(std::span<const Event> events, std::span<std::byte> bytes) {
  std::byte* to = bytes.data();
  const auto room = [&] {
    return (bytes.size() - static_cast<std::size_t>(to - bytes.data())) / kMaxPerEvent;
  };
  State state = state_;
  std::int64_t last = earliest<Format>(state);
  std::size_t i = 0;
  const auto refuse_this = [&] {
    state.events += i;
    if (i > 0) state.last_t = last;
    refuse<Format>(State(state), events[i]);  // a copy: state stays in registers
  };
  while (i < events.size() && room() > 0) {
    for (const std::size_t end = i + std::min(events.size() - i, room()); i < end; ++i) {
      const Event& event = events[i];
      const bool held = event.t >= last && event.t <= Format::kMaxTime &&
                        (event.x | event.y) <= static_cast<int>(Format::kMaxAddress);
      if (!held) [[unlikely]] {
        refuse_this();
      }
      if constexpr (CountsTime<Format>) {
        if (!Format::follows(state, event.t)) [[unlikely]] {
          if (event.t - state.t > Format::kMaxGap) refuse_this();
          to = Format::mark(state, event.t, to);
          break;
        }
      }
      Event stored = event;
      if constexpr (Format::kRowsUp) {
        stored.y = static_cast<std::uint16_t>(config_.height - 1 - stored.y);
      }
      to = Format::put(state, stored, to);
      last = event.t;
    }
  }
  if (i > 0) state.last_t = last;
  state.events += i;
  state_ = state;
  return {.bytes = static_cast<std::size_t>(to - bytes.data()), .events = i};
}

}  // namespace asap::inline v0_1
