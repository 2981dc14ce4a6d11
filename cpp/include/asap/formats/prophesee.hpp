// Prophesee's files: the text header of RAW and DAT, and a decoder each for EVT2, EVT2.1, EVT3 and
// DAT. Feed a decoder what follows the header, cut anywhere.
//
// One thread per decoder, any thread for a header. Never throws on bytes, never allocates.
// O(bytes).
//
//   Evt3Decoder decoder;
//   decoder.decode(bytes, events);  // behind the header, cut anywhere
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "asap/core/event.hpp"
#include "asap/formats/decoder.hpp"

namespace asap::inline v0_1 {

// ---- header ------------------------------------------------------------------------------------

// read_raw_header: the text before the words of a Prophesee RAW or DAT file.
//
// Lines "% key value", each ended by a newline, up to "% end" or the first line of another kind.
// Keys: evt 2.0 | 2.1 | 3.0 (old); format EVT3;height=720;width=1280 (new, counts more), geometry
// 1280x720, endianness, plugin_name (of old recordings, names the sensor). DAT: Version, Width,
// Height, then two bytes, type and size of an event; read_dat_header reads them. Numbers that are
// absurd count as absent.

struct RawHeader {
  enum class Words : std::uint8_t { unknown, evt2, evt21, evt3 };

  std::size_t size = 0;  // bytes; the first word begins there
  Words words = Words::unknown;
  bool little_endian = false;  // said so; EVT2.1 swaps the halves of its words otherwise
  bool is_dat = false;         // "Data file containing ..."
  int version = -1;            // version of a DAT file; -1: not stated
  int width = 0;               // px; 0: not stated
  int height = 0;
};

// Nothing if `bytes` do not begin with such a line. Give enough bytes: a header that is cut ends
// where they end.
std::optional<RawHeader> read_raw_header(std::span<const std::byte> bytes) noexcept;

// ---- EVT2 --------------------------------------------------------------------------------------

// Evt2Decoder: events of a Prophesee EVT2 stream, 32-bit little-endian words.
//
// Type in bits 31:28: 0 OFF and 1 ON with t 27:22, x 21:11, y 10:0; 8 TIME_HIGH with t >> 6 in
// 27:0, often repeated; 10 external trigger with t 27:22, id 12:8, value 0; 14 and 15 others.
// Times unwrap every 2^34 us, where TIME_HIGH falls by more than half its range. Events before the
// first TIME_HIGH are dropped: their time is unknown.

struct Evt2Config {
  std::uint64_t first_offset = 0;  // offset in the file of the first byte that is fed
};

// What EVT2 shares with EVT2.1, whose upper 32 bits are laid out alike: time and rare words.
template <class Decoder, class Config, std::size_t kRecord>
class Evt2Words : public NativeDecoder<Decoder, Config, kRecord> {
 protected:
  using NativeDecoder<Decoder, Config, kRecord>::NativeDecoder;

  // Any word that is no event; false without room for it.
  bool decode_other(std::uint32_t word, std::uint64_t offset, Output& out) noexcept;

  std::int64_t high_ = 0;  // us, of the last TIME_HIGH, unwrapped
  bool started_ = false;   // a TIME_HIGH came
};

class Evt2Decoder : public Evt2Words<Evt2Decoder, Evt2Config, 4> {
 public:
  static constexpr std::size_t kMaxPerRecord = 1;  // events that one word can give
  static constexpr std::string_view kFormat = "evt2";
  static bool begins(std::span<const std::byte> front) noexcept;
  static OpenedRecording open(const RecordingFile& file);

  explicit Evt2Decoder(Evt2Config config = {}) noexcept : Evt2Words(config, config.first_offset) {}

 private:
  friend NativeDecoder;

  std::size_t decode_words(const std::byte* first, std::size_t count, Output& out) noexcept;
};

// ---- EVT2.1 ------------------------------------------------------------------------------------

// Evt21Decoder: events of a Prophesee EVT2.1 stream, 64-bit words that hold up to 32 events.
//
// Type in bits 63:60: 0 OFF and 1 ON with t 59:54, x 53:43, y 42:32 and a mask in 31:0, whose bit i
// is an event at x + i; 8 TIME_HIGH with t >> 6 in 59:32, often repeated; 10 external trigger with
// t 59:54, id 44:40, value 32; 14 and 15 others. Little-endian words, or "legacy": their two 32-bit
// halves are swapped. Only the header says which; without the key the practice is legacy.
// Times unwrap every 2^34 us, where TIME_HIGH falls by more than half its range. Events before the
// first TIME_HIGH are dropped: their time is unknown.

struct Evt21Config {
  bool little_endian = false;      // else legacy
  std::uint64_t first_offset = 0;  // offset in the file of the first byte that is fed
};

class Evt21Decoder : public Evt2Words<Evt21Decoder, Evt21Config, 8> {
 public:
  static constexpr std::size_t kMaxPerRecord = 32;  // events that one word can give
  static constexpr std::string_view kFormat = "evt21";
  static bool begins(std::span<const std::byte> front) noexcept;
  static OpenedRecording open(const RecordingFile& file);

  explicit Evt21Decoder(Evt21Config config = {}) noexcept
      : Evt2Words(config, config.first_offset) {}

 private:
  friend NativeDecoder;

  std::size_t decode_words(const std::byte* first, std::size_t count, Output& out) noexcept;
  template <bool kLittleEndian>
  std::size_t decode_in_order(const std::byte* first, std::size_t count, Output& out) noexcept;
  bool decode_any(std::uint64_t word, std::uint64_t offset, Output& out) noexcept;
};

// ---- EVT3 --------------------------------------------------------------------------------------

// Evt3Decoder: events of a Prophesee EVT3 stream, 16-bit little-endian words that change a state.
//
// Type in bits 15:12: 0 ADDR_Y with y 10:0; 2 ADDR_X with p 11, x 10:0: an event; 3 VECT_BASE_X
// with p 11, x 10:0; 4 VECT_12 and 5 VECT_8: a mask from bit 0, whose bit i is an event at base +
// i, then the base moves by 12 or 8; 6 TIME_LOW and 8 TIME_HIGH, 12 bits each; 10 external trigger
// with id 11:8, value 0; 7, 14 and 15 others. Time is (TIME_HIGH << 12) + TIME_LOW: TIME_LOW may
// step back; a repeated TIME_HIGH changes nothing, another one sets TIME_LOW to 0. Unwraps every
// 2^24 us, where TIME_HIGH falls by more than half its range. Camera drivers cut the stream
// anywhere: keep one decoder over all packets. Words 0x9999 are padding. Events before the first
// TIME_HIGH, ADDR_Y or base are dropped: what they are is not known.

struct Evt3Config {
  std::uint64_t first_offset = 0;  // offset in the file of the first byte that is fed
};

class Evt3Decoder : public NativeDecoder<Evt3Decoder, Evt3Config, 2> {
 public:
  static constexpr std::size_t kMaxPerRecord = 12;  // events that one word can give
  static constexpr std::string_view kFormat = "evt3";
  static bool begins(std::span<const std::byte> front) noexcept;
  static OpenedRecording open(const RecordingFile& file);

  explicit Evt3Decoder(Evt3Config config = {}) noexcept
      : NativeDecoder(config, config.first_offset) {}

  // Bytes are missing here: events up to the next whole time (TIME_HIGH, then TIME_LOW or another
  // TIME_HIGH), ADDR_Y or base are dropped. The time goes on.
  void resume() noexcept {
    high_word_ = 0;
    has_low_ = false;
    has_y_ = false;
    has_base_ = false;
  }

 private:
  friend NativeDecoder;

  std::size_t decode_words(const std::byte* first, std::size_t count, Output& out) noexcept;
  bool decode_plain(std::uint32_t word, std::uint64_t offset, Output& out) noexcept;
  std::size_t decode_fast(const std::byte* first, std::size_t i, std::size_t end,
                          Output& out) noexcept;
  void take_time_high(std::uint32_t word) noexcept;

  std::int64_t t_ = 0;           // us, unwrapped
  std::int64_t high_ = 0;        // us, of the last TIME_HIGH, unwrapped
  std::uint32_t high_word_ = 0;  // the last TIME_HIGH; 0: none came yet
  std::uint32_t y_ = 0;          // px
  std::uint32_t base_ = 0;       // the last VECT_BASE_X, moved by vectors
  bool has_low_ = true;          // false between a gap and the next whole time
  bool has_y_ = false;
  bool has_base_ = false;
};

// ---- DAT ---------------------------------------------------------------------------------------

// DatDecoder: events of a Prophesee DAT file, 8 bytes each.
//
// t in us, 32 bits; then version 2: x 13:0, y 27:14, p 31:28; version 1: x 8:0, y 16:9, p 17. Types
// 0 and 12 are both change detections. Times unwrap every 2^32 us, where they fall by more than
// half of it. Any 8 bytes are an event: none are bad; polarity is the Validator's.

struct DatConfig {
  int version = 2;
  std::uint64_t first_offset = 0;  // offset in the file of the first byte that is fed
};

struct DatHeader {
  std::size_t size = 0;  // bytes, type and size of an event included
  int version = 2;       // where it is not stated, the first events decide
  std::uint8_t type = 0;
  std::uint8_t event_size = 0;  // bytes
  int width = 0;                // px; 0: not stated
  int height = 0;
};

// Nothing if `bytes` do not begin with a header of text lines and two bytes.
std::optional<DatHeader> read_dat_header(std::span<const std::byte> bytes) noexcept;

class DatDecoder : public NativeDecoder<DatDecoder, DatConfig, 8> {
 public:
  static constexpr std::size_t kMaxPerRecord = 1;  // events
  static constexpr std::string_view kFormat = "dat";
  static bool begins(std::span<const std::byte> front) noexcept;
  static OpenedRecording open(const RecordingFile& file);

  explicit DatDecoder(DatConfig config = {});

 private:
  friend NativeDecoder;

  std::size_t decode_words(const std::byte* first, std::size_t count, Output& out) noexcept;
  template <int kVersion>
  std::size_t decode_version(const std::byte* first, std::size_t count, Output& out) noexcept;

  std::int64_t t_ = 0;  // us, of the last event, unwrapped
};

}  // namespace asap::inline v0_1
