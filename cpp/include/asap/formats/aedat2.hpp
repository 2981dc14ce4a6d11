// Aedat2Decoder: events from AEDAT 2.0 files, which jAER writes; and their header.
//
// Layout: "#!AER-DAT2.0", lines that begin with '#' (maybe 170 kB of preferences), then records of
// 8 bytes, big-endian: u32 address, u32 time in us, which wraps. What the address means depends on
// the chip, which the line "# AEChip:" names:
//   DAVIS   bit 31 0, bit 10 0: an event; y 30:22, x 21:12, ON 11. Bit 31 1: frames and motion
//           sensor. Bit 31 0, bit 10 1: an external trigger.
//   DVS128  bits 31 and 15 0: an event; y 14:8, x 7:1, OFF 0. Else an external trigger.
// x counts from the right and y from below: both are turned, so that (0, 0) is top left, as jAER
// shows them. A trigger has no number and no edge: id 0, value 1. Every record has a meaning.
// Source: jAER (SensorsINI/jaer), event extractors of DAVIS and DVS128.
// One thread. O(bytes), no allocation, never throws.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "asap/core/event.hpp"
#include "asap/formats/progress.hpp"

namespace asap {

// unnamed: no line says it, and the first addresses do not tell. other: it is not decoded.
enum class Aedat2Chip : std::uint8_t { unnamed, other, davis, dvs128 };

struct Aedat2Header {
  std::size_t size;  // bytes; the first record follows
  Aedat2Chip chip;
  std::uint16_t width, height;  // px; 0 where the header does not say
};

// Nothing where `front` is not AEDAT 2.0 or ends inside a line. Where it ends with a line, more
// lines may follow.
std::optional<Aedat2Header> read_aedat2_header(std::span<const std::byte> front) noexcept;

struct Aedat2Config {
  Aedat2Chip chip = Aedat2Chip::davis;
  std::uint16_t width = 240, height = 180;  // of the sensor, px: x and y are mirrored in it
};

// Feed it what follows the header.
class Aedat2Decoder : public NativeDecoder<Aedat2Decoder, Aedat2Config, 8> {
 public:
  static constexpr std::size_t kMostPerRecord = 1;

  explicit Aedat2Decoder(const Aedat2Config& config = {});

 private:
  friend NativeDecoder;

  std::size_t decode_bytes(std::span<const std::byte> bytes, Output& out) noexcept;

  // The shorter way from here to any first time of 32 bits makes it one without a sign.
  static constexpr std::int64_t kBeforeFirst = std::int64_t{1} << 31;

  std::int64_t t_ = kBeforeFirst;  // us, of the last record
};

}  // namespace asap
