// AEDAT files: header and decoder of AEDAT 2.0, which jAER writes, and of AEDAT 3.1, which cAER
// writes. Feed a decoder what follows the header, cut anywhere.
// One thread per decoder, any thread for a header. O(bytes), no allocation, never throws on bytes.
//
//   if (const auto header = read_aedat2_header(bytes)) {
//     Aedat2Decoder decoder{{.chip = header->chip}};
//     decoder.decode(bytes.subspan(header->size), events);
//   }
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "asap/core/event.hpp"
#include "asap/formats/decoder.hpp"

namespace asap::inline v0_1 {

// ---- AEDAT 2.0 ---------------------------------------------------------------------------------

// Aedat2Decoder: events from AEDAT 2.0 files, which jAER writes; and their header.
//
// Layout: "#!AER-DAT2.0", lines that begin with '#' (maybe 170 kB of preferences), then records of
// 8 bytes, big-endian: u32 address, u32 time in us, which wraps. What the address means depends on
// the chip, which the line "# AEChip:" names:
//   DAVIS   bit 31 0, bit 10 0: an event; y 30:22, x 21:12, ON 11. Bit 31 1: frames and motion
//           sensor. Bit 31 0, bit 10 1: an external trigger. DVXplorer: the same.
//           Several DAVIS in one file: the number of the camera 3:0.
//   DVS128  bits 31 and 15 0: an event; y 14:8, x 7:1, OFF 0. Else an external trigger.
//           A stereo pair: bit 15 1 is the right one. Several: the number of the camera 31:24.
//   DVS640  bits 31:20 0: an event; y 19:11, x 10:1, ON 0. As v2e writes it.
//   DVS1280 bits 31:22 0: an event; y 21:12, x 11:1, ON 0.
// x counts from the right and y from below: both are turned, so that (0, 0) is top left, as jAER
// shows them. A trigger has no number and no edge: id 0, value 1. Every record has a meaning.
// Source: jAER (SensorsINI/jaer), event extractors of these chips.

// unnamed: neither the header nor the first addresses tell the chip. other: a chip that is not
// decoded.
enum class Aedat2Chip : std::uint8_t { unnamed, other, davis, dvs128, dvs640, dvs1280 };

struct Aedat2Header {
  std::size_t size;  // bytes; the first record follows
  Aedat2Chip chip;
  int width, height;          // px; 0 where the header does not say
  std::uint32_t camera_bits;  // of the addresses, that number several cameras; 0: there is one
};

// Nothing where `front` is not AEDAT 2.0 or ends inside a line. Where it ends with a line, more
// lines may follow.
std::optional<Aedat2Header> read_aedat2_header(std::span<const std::byte> front) noexcept;

struct Aedat2Config {
  Aedat2Chip chip = Aedat2Chip::davis;
  int width = 240, height = 180;  // px of the sensor, in which x and y are mirrored
  std::uint32_t camera_bits = 0;  // as in the header
  std::uint32_t camera = 0;       // the one to decode, where there are several
};

// Feed it what follows the header.
class Aedat2Decoder : public NativeDecoder<Aedat2Decoder, Aedat2Config, 8> {
 public:
  static constexpr std::size_t kMaxPerRecord = 1;
  static constexpr std::string_view kFormat = "aedat2";
  static bool begins(std::span<const std::byte> front) noexcept;
  static OpenedRecording open(const RecordingFile& file);

  explicit Aedat2Decoder(const Aedat2Config& config = {});

 private:
  friend NativeDecoder;

  std::size_t decode_bytes(std::span<const std::byte> bytes, Output& out) noexcept;

  std::int64_t t_ = 0;  // us, of the last record, unwrapped
};

// ---- AEDAT 3.1 ---------------------------------------------------------------------------------

// Aedat3Decoder: polarity events from AEDAT 3.1 files, which cAER writes; and their header.
//
// Layout: "#!AER-DAT3.1", lines that begin with '#', "#!END-HEADER", then packets. All numbers are
// little-endian. A packet's header has 28 bytes: i16 type, i16 source, i32 bytes per event, i32
// offset of the time in it, i32 overflows of the time, i32 capacity, i32 events, i32 valid events.
// A polarity event (type 1) has 8 bytes: u32 data, i32 time in us; the 64-bit time is overflows <<
// 31 | time. Data: bit 0 valid, bit 1 ON, y 16:2, x 31:17; (0, 0) is top left. In a special event
// (type 0) bits 7:1 say what it is: 2, 3, 4 are external triggers, whose id is 0; a pulse rises.
// Other packets are skipped. Bytes that are no packet's header are skipped to the next header of
// polarity events, and are one bad record.
// Source: inivation.com, "AEDAT 3.1"; libcaer, events/.

struct Aedat3Header {
  std::size_t size;     // bytes; the first packet follows
  bool raw;             // "#Format: RAW": the only one that is decoded
  std::size_t sources;  // cameras in the file
  int width, height;    // px of the first source; 0 where its name does not say
};

// Nothing where `front` is not AEDAT 3.1, or ends inside the header.
std::optional<Aedat3Header> read_aedat3_header(std::span<const std::byte> front) noexcept;

struct Aedat3Config {
  int source = -1;                 // number of the camera; -1: all of them
  std::uint64_t first_offset = 0;  // offset in the file of the first byte that is fed
};

// Feed it what follows the header.
class Aedat3Decoder : public NativeDecoder<Aedat3Decoder, Aedat3Config, 28> {
 public:
  static constexpr std::size_t kMaxPerRecord = 1;
  static constexpr std::string_view kFormat = "aedat3";
  static bool begins(std::span<const std::byte> front) noexcept;
  static OpenedRecording open(const RecordingFile& file);

  explicit Aedat3Decoder(const Aedat3Config& config = {});

  // Bytes of a packet that waits for its end; its events so far have been decoded. At the end of
  // the input: the file was cut.
  std::size_t unfinished() const noexcept {
    return packet_left_ > 0 ? static_cast<std::size_t>(offset_ - packet_at_) : cut_.size;
  }

  // Events that the recording program took out, by a mark: they are none.
  std::uint64_t invalid() const noexcept { return invalid_; }

 private:
  friend NativeDecoder;

  static constexpr std::size_t kMinRecord = 8;  // bytes of an event in a packet

  enum class Packet : std::uint8_t { polarity, special, other };
  static constexpr std::size_t kHeader = 28;

  std::size_t decode_bytes(std::span<const std::byte> bytes, Output& out) noexcept;
  std::size_t take_header(std::span<const std::byte> bytes) noexcept;
  std::size_t take_packet(std::span<const std::byte> bytes, Output& out) noexcept;

  Packet packet_ = Packet::other;
  std::int64_t overflow_us_ = 0;
  std::uint64_t packet_at_ = 0;    // its offset in the file
  std::uint64_t packet_left_ = 0;  // bytes of the packet that have not been consumed
  bool lost_ = false;              // between a bad header and the next good one
  std::uint64_t invalid_ = 0;
};

}  // namespace asap::inline v0_1
