// Aedat3Decoder: polarity events from AEDAT 3.1 files, which cAER writes; and their header.
//
// Layout: "#!AER-DAT3.1", lines that begin with '#', "#!END-HEADER", then packets. All numbers are
// little-endian. A packet's header has 28 bytes: i16 type, i16 source, i32 bytes per event, i32
// offset of the time in it, i32 overflows of the time, i32 capacity, i32 events, i32 valid events.
// A polarity event (type 1) has 8 bytes: u32 data, i32 time in us; the 64-bit time is overflows <<
// 31 | time. Data: bit 0 valid, bit 1 ON, y 16:2, x 31:17; (0, 0) is top left. In a special event
// (type 0) bits 7:1 say what it is: 2, 3, 4 are external triggers. Other packets are skipped.
// Source: inivation.com, "AEDAT 3.1"; libcaer, events/.
// One thread. Feed it bytes cut anywhere. O(bytes), no allocation, never throws.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "asap/core/event.hpp"
#include "asap/formats/progress.hpp"

namespace asap {

struct Output;

struct Aedat3Header {
  std::size_t size;             // bytes; the first packet follows
  bool raw;                     // "#Format: RAW": the only one that is decoded
  std::size_t sources;          // cameras in the file
  std::uint16_t width, height;  // px of the first source; 0 where its name does not say
};

// Nothing where `front` is not AEDAT 3.1, or ends inside the header.
std::optional<Aedat3Header> read_aedat3_header(std::span<const std::byte> front) noexcept;

struct Aedat3Config {
  int source = -1;                 // number of the camera; -1: all of them
  std::uint64_t first_offset = 0;  // offset in the file of the first byte that is fed
};

class Aedat3Decoder {
 public:
  static constexpr std::size_t kMostPerRecord = 1;

  explicit Aedat3Decoder(const Aedat3Config& config = {});

  // Decodes from the front of `bytes`, which follow the header, until one of them ends.
  Progress decode(std::span<const std::byte> bytes, std::span<Event> events) noexcept;

  // The same; stops before a trigger that has no room as well. Its id is 0; a pulse rises.
  Progress decode(std::span<const std::byte> bytes, std::span<Event> events,
                  std::span<Trigger> triggers) noexcept;

  // Bytes of a packet that waits for its end; its events so far have been decoded. At the end of
  // the input: the file was cut.
  std::size_t unfinished() const noexcept {
    return packet_left_ > 0 ? static_cast<std::size_t>(offset_ - packet_at_) : cut_.size;
  }

  // Bytes that are no packet's header are skipped to the next header of polarity events, and
  // counted once; noted(): byte offsets of the first. Events that are marked as invalid were
  // taken out by the recording program: they are none, and counted in invalid().
  std::uint64_t bad_records() const noexcept { return bad_.count(); }
  std::span<const std::uint64_t> noted() const noexcept { return bad_.noted(); }
  std::uint64_t invalid() const noexcept { return invalid_; }
  std::uint64_t triggers() const noexcept { return triggers_; }

  void reset() noexcept;

 private:
  enum class Packet : std::uint8_t { polarity, special, other };
  static constexpr std::size_t kHeader = 28;

  Progress decode(std::span<const std::byte> bytes, Output out) noexcept;
  std::size_t take_header(std::span<const std::byte> bytes) noexcept;
  std::size_t take_packet(std::span<const std::byte> bytes, Output& out) noexcept;

  Aedat3Config config_;
  std::uint64_t offset_;
  Packet packet_ = Packet::other;
  std::int64_t overflow_us_ = 0;
  std::uint64_t packet_at_ = 0;    // its offset in the file
  std::uint64_t packet_left_ = 0;  // bytes of the packet that have not been consumed
  bool lost_ = false;              // between a bad header and the next good one
  BadRecords bad_;
  std::uint64_t invalid_ = 0;
  std::uint64_t triggers_ = 0;
  CutRecord<kHeader> cut_;
};

}  // namespace asap
