// The short records of ATIS recordings: Event Stream files (.es), and events of 40 bits (.bin,
// .bs2). Feed a decoder the records, cut anywhere. One thread per decoder, any thread for a header.
// O(bytes), no allocation, never throws on bytes.
//
//   Atis40Decoder decoder;
//   decoder.decode(bytes, events);
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "asap/core/event.hpp"
#include "asap/formats/decoder.hpp"

namespace asap::inline v0_1 {

// ---- Event Stream ------------------------------------------------------------------------------

// EventStreamDecoder: events from the bytes of an Event Stream file (.es, type DVS).
//
// Layout, version 2: "Event Stream", 3 bytes version, 1 byte type (1 = DVS), u16 width, u16 height,
// then records. An event has 5 bytes: time since the last event in us << 1 | polarity, u16 x, u16
// y, little-endian. One byte 0xff adds 127 us, one byte 0xfe is padding. Version 1: 2 bytes
// version, 1 byte type (0 = DVS), no size; an event has 3 bytes: time 4 bits, x 10, y 9, polarity
// 1, lowest first; a byte whose low half is 15 adds 15 us times its high half. Row 0 is the bottom
// one: rows are turned by the sensor's height, so that (0, 0) is top left. Source: the
// specification, neuromorphic-paris/event_stream; rows: its reference, neuromorphic-paris/sepia.
// Every byte has a meaning: there are no bad records and no triggers.

struct EventStreamHeader {
  enum class Type : std::uint8_t { generic, dvs, atis, display, color, unknown };

  std::size_t size;   // bytes; the first record follows
  int version;        // major version
  Type type;          // only dvs is decoded
  int width, height;  // px; 0 where the file does not say
};

// Nothing where `front` does not begin with a whole header of version 1 or 2.
std::optional<EventStreamHeader> read_event_stream_header(
    std::span<const std::byte> front) noexcept;

struct EventStreamConfig {
  int version = 2;  // 1 or 2, as the header says
  int height = 0;   // rows of the sensor; version 1 does not say it: 240 for an ATIS
};

// Feed it what follows the header. The first event's time counts from 0.
class EventStreamDecoder : public NativeDecoder<EventStreamDecoder, EventStreamConfig, 5> {
 public:
  static constexpr std::size_t kMaxPerRecord = 1;
  static constexpr std::string_view kFormat = "es";
  static bool begins(std::span<const std::byte> front) noexcept;
  static OpenedRecording open(const RecordingFile& file);

  explicit EventStreamDecoder(const EventStreamConfig& config);

 private:
  friend NativeDecoder;

  static constexpr std::size_t kMinRecord = 3;  // bytes of an event of version 1

  std::size_t decode_bytes(std::span<const std::byte> bytes, Output& out) noexcept;

  std::int64_t t_ = 0;  // us, of the last event
};

// ---- 40 bits -----------------------------------------------------------------------------------

// Atis40Decoder: events of 40 bits, as N-MNIST and N-Caltech101 (.bin) and DvsGesture cuts (.bs2)
// hold them.
//
// Layout: no header. A record has 5 bytes, big-endian: x 8 bits, y 8, polarity 1, time in us 23. A
// record with y = 240, one row below the sensor, is no event: it adds 2^13 us to all times that
// follow. Source: the readers of the N-MNIST data set (Orchard et al. 2015). Nothing in these bytes
// tells the format: only the name of the file or the user does. Every record has a meaning: there
// are no bad records and no triggers.

struct Atis40Config {
  bool marks = true;  // whether y = 240 marks 2^13 us; false: it is a row like any other
};

class Atis40Decoder : public NativeDecoder<Atis40Decoder, Atis40Config, 5> {
 public:
  static constexpr std::size_t kMaxPerRecord = 1;
  static constexpr std::string_view kFormat = "atis40";
  static bool begins(std::span<const std::byte> front) noexcept;
  static OpenedRecording open(const RecordingFile& file);

  explicit Atis40Decoder(const Atis40Config& config = {}) noexcept : NativeDecoder(config) {}

 private:
  friend NativeDecoder;

  std::size_t decode_bytes(std::span<const std::byte> bytes, Output& out) noexcept;

  std::int64_t marked_us_ = 0;
};

}  // namespace asap::inline v0_1
