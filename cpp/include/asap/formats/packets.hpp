// MonoDecoder, LibcaerDecoder, LibcaerCmpDecoder: events in messages of event_camera_msgs (ROS);
// its encoding "evt3" is the Evt3Decoder's. DvsRecords: events of dvs_msgs. Little-endian.
//
// mono: u64 = ns after time_base 31:0, x 47:32, y 62:48, p 63.
// libcaer: u32 = p 1, y 16:2, x 31:17, then i32 us after time_base, which wraps after 2^31 us.
// libcaer_cmp: u16 = code 15:12 and value: 0 TIME_HIGH (us >> 12), 1 TIME_LOW, 2 ADDR_X,
// 3 ADDR_Y + p 11 (an event), 4 VECT_BASE_Y + p 11, 5 VECT_8: a mask 7:0 of y; base += 8.
// dvs_msgs: u16 x, u16 y, u32 s, u32 ns, u8 p: 13 bytes in ROS 1; aligned in ROS 2 (CDR).
// Source: README and types of event_camera_msgs and event_camera_codecs.
//
// One thread. begin() with the time_base of each message, then its bytes, cut anywhere. Never
// throws, never allocates. O(bytes). Times are us of time_base + offset, rounded down; order and
// sensor size are the Validator's.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "asap/core/event.hpp"
#include "asap/formats/progress.hpp"

namespace asap {

struct Output;

struct PacketConfig {
  std::uint64_t first_offset = 0;  // of the first byte that is fed, for noted()
};

class MonoDecoder {
 public:
  static constexpr std::size_t kMostPerRecord = 1;  // events that one record can give

  explicit MonoDecoder(PacketConfig config = {}) noexcept : config_(config) { reset(); }

  // The next message. A record that the last one left unfinished is bad.
  void begin(std::uint64_t time_base_ns) noexcept;

  // Decodes from the front of `bytes` until they end or the next record has no room. Events beyond
  // those reported are overwritten.
  Progress decode(std::span<const std::byte> bytes, std::span<Event> events) noexcept;

  // Bytes of a record that waits for its end; > 0 at the end of a message: it was cut.
  std::size_t unfinished() const noexcept { return state_.cut.size; }

  std::uint64_t bad_records() const noexcept { return state_.bad.count(); }
  std::span<const std::uint64_t> noted() const noexcept { return state_.bad.noted(); }
  void reset() noexcept;

 private:
  struct State {
    std::uint64_t offset = 0;  // of the next record
    std::int64_t base_us = 0;
    std::uint64_t base_rest_ns = 0;
    BadRecords bad;
    CutRecord<8> cut;
  };

  PacketConfig config_;
  State state_;
};

class LibcaerDecoder {
 public:
  static constexpr std::size_t kMostPerRecord = 1;

  explicit LibcaerDecoder(PacketConfig config = {}) noexcept : config_(config) { reset(); }

  void begin(std::uint64_t time_base_ns) noexcept;  // as above, and so on
  Progress decode(std::span<const std::byte> bytes, std::span<Event> events) noexcept;
  std::size_t unfinished() const noexcept { return state_.cut.size; }

  // Records with a negative stamp.
  std::uint64_t bad_records() const noexcept { return state_.bad.count(); }
  std::span<const std::uint64_t> noted() const noexcept { return state_.bad.noted(); }
  void reset() noexcept;

 private:
  struct State {
    std::uint64_t offset = 0;
    std::int64_t base_us = 0;  // of the stamps that follow: grows where they wrap
    std::int32_t last_stamp = 0;
    BadRecords bad;
    CutRecord<8> cut;
  };

  std::size_t decode_records(const std::byte* first, std::size_t count, Output& out) noexcept;

  PacketConfig config_;
  State state_;
};

class LibcaerCmpDecoder {
 public:
  static constexpr std::size_t kMostPerRecord = 8;

  explicit LibcaerCmpDecoder(PacketConfig config = {}) noexcept : config_(config) { reset(); }

  void begin(std::uint64_t time_base_ns) noexcept;

  // Stops with less than kMostPerRecord room, whatever the next word is.
  Progress decode(std::span<const std::byte> bytes, std::span<Event> events) noexcept;
  std::size_t unfinished() const noexcept { return state_.cut.size; }

  // Words of another code.
  std::uint64_t bad_records() const noexcept { return state_.bad.count(); }
  std::span<const std::uint64_t> noted() const noexcept { return state_.bad.noted(); }
  void reset() noexcept;

 private:
  struct Registers {
    std::int64_t high = 0;  // us
    std::int64_t low = 0;   // us
    std::uint32_t x = 0;
    std::uint32_t base_y = 0;
    std::uint32_t base_p = 0;
  };
  struct State {
    std::uint64_t offset = 0;
    std::int64_t base_us = 0;
    Registers registers;
    BadRecords bad;
    CutRecord<2> cut;
  };

  std::size_t decode_words(const std::byte* first, std::size_t count, Output& out) noexcept;

  PacketConfig config_;
  State state_;
};

// The array of events in one dvs_msgs/EventArray, whose bytes begin at its first event.
class DvsRecords {
 public:
  enum class Layout : std::uint8_t { ros1, cdr };

  DvsRecords(std::span<const std::byte> bytes, Layout layout) noexcept
      : bytes_(bytes), layout_(layout) {}

  std::size_t whole() const noexcept;  // records that end within the bytes

  // Fills `events` with the records from number `first` on; first + events.size() <= whole().
  void decode(std::size_t first, std::span<Event> events) const noexcept;

 private:
  std::span<const std::byte> bytes_;
  Layout layout_;
};

}  // namespace asap
