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
// begin() with the time_base in ns of each message, then its bytes, cut anywhere; a record that the
// message before left unfinished is bad. Times are us of time_base + offset, rounded down.
//
// One thread. Never throws, never allocates. O(bytes).
//
//   MonoDecoder decoder;
//   decoder.begin(/*time_base_ns=*/0);
//   decoder.decode(bytes, events);
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "asap/core/event.hpp"
#include "asap/formats/decoder.hpp"

namespace asap::inline v0_1 {

struct PacketConfig {
  std::uint64_t first_offset = 0;  // offset of the first byte that is fed, for noted()
};

class MonoDecoder : public NativeDecoder<MonoDecoder, PacketConfig, 8> {
 public:
  static constexpr std::size_t kMaxPerRecord = 1;  // events that one record can give

  explicit MonoDecoder(PacketConfig config = {}) noexcept
      : NativeDecoder(config, config.first_offset) {}

  void begin(std::uint64_t time_base_ns) noexcept;

 private:
  friend NativeDecoder;

  std::size_t decode_words(const std::byte* first, std::size_t count, Output& out) noexcept;

  std::int64_t base_us_ = 0;
  std::uint64_t base_rest_ns_ = 0;
};

// Records with a negative timestamp are bad.
class LibcaerDecoder : public NativeDecoder<LibcaerDecoder, PacketConfig, 8> {
 public:
  static constexpr std::size_t kMaxPerRecord = 1;

  explicit LibcaerDecoder(PacketConfig config = {}) noexcept
      : NativeDecoder(config, config.first_offset) {}

  void begin(std::uint64_t time_base_ns) noexcept;

 private:
  friend NativeDecoder;

  std::size_t decode_words(const std::byte* first, std::size_t count, Output& out) noexcept;

  std::int64_t base_us_ = 0;  // base of the timestamps that follow; grows where they wrap
  std::int32_t last_stamp_ = 0;
};

// Words of another code are bad. Stops with less than kMaxPerRecord room, whatever the next word
// is.
class LibcaerCmpDecoder : public NativeDecoder<LibcaerCmpDecoder, PacketConfig, 2> {
 public:
  static constexpr std::size_t kMaxPerRecord = 8;

  explicit LibcaerCmpDecoder(PacketConfig config = {}) noexcept
      : NativeDecoder(config, config.first_offset) {}

  void begin(std::uint64_t time_base_ns) noexcept;

 private:
  friend NativeDecoder;

  struct Registers {
    std::int64_t high = 0;  // us
    std::int64_t low = 0;   // us
    std::uint32_t x = 0;
    std::uint32_t base_y = 0;
    std::uint32_t base_p = 0;
  };

  std::size_t decode_words(const std::byte* first, std::size_t count, Output& out) noexcept;

  std::int64_t base_us_ = 0;
  Registers registers_;
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

}  // namespace asap::inline v0_1
