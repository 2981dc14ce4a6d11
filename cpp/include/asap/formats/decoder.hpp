// NativeDecoder: what the decoder of every format offers: how far a call came, the triggers it met,
// bad records, and the bytes of a record that was cut. One thread. Never throws on bytes, allocates
// only in a vector that it fills. decode() is O(bytes), the rest O(1).
//
//   while (read(file, bytes)) decoder.decode(bytes, events);  // cut anywhere; events are appended
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "asap/core/event.hpp"

namespace asap::inline v0_1 {

struct Output;
struct RecordingFile;
struct OpenedRecording;

// What one call of decode() consumed and wrote.
struct Progress {
  std::size_t bytes = 0;
  std::size_t events = 0;
  std::size_t triggers = 0;  // into the third span; 0 without it

  friend bool operator==(const Progress&, const Progress&) = default;
};

// An edge at an external input of the camera. 16 bytes.
struct Trigger {
  std::int64_t t;       // us of the sensor's clock
  std::uint16_t id;     // number of the input
  std::uint16_t value;  // 1 = rising, 0 = falling edge

  friend bool operator==(const Trigger&, const Trigger&) = default;
};

// Bad records: how many, and the byte offsets of the first.
class BadRecords {
 public:
  static constexpr std::size_t kNoted = 16;

  void add(std::uint64_t offset) noexcept {
    if (count_ < kNoted) noted_[static_cast<std::size_t>(count_)] = offset;
    ++count_;
  }

  std::uint64_t count() const noexcept { return count_; }

  std::span<const std::uint64_t> noted() const noexcept {
    return {noted_.data(), static_cast<std::size_t>(std::min<std::uint64_t>(count_, kNoted))};
  }

 private:
  std::array<std::uint64_t, kNoted> noted_{};
  std::uint64_t count_ = 0;
};

// The first bytes of a record of kSize bytes whose end is yet to come.
template <std::size_t kSize>
struct CutRecord {
  std::array<std::byte, kSize> bytes{};
  std::size_t size = 0;  // < kSize between two calls
};

// The base of the decoders of this library; the longest record has kRecord bytes. Feed it bytes cut
// anywhere. The Validator checks order and sensor size of the events.
template <class Decoder, class Config, std::size_t kRecord>
class NativeDecoder {
 public:
  // Decodes from the front of `bytes` until they end or the next record has no room. Events beyond
  // those reported are overwritten.
  [[nodiscard]] Progress decode(std::span<const std::byte> bytes, std::span<Event> events) noexcept;

  // The same; stops before a trigger that has no room as well.
  [[nodiscard]] Progress decode(std::span<const std::byte> bytes, std::span<Event> events,
                                std::span<Trigger> triggers) noexcept;

  // Appends the events of all records that end in `bytes`.
  void decode(std::span<const std::byte> bytes, std::vector<Event>& events);

  // Room that the events of so many bytes never fill, so that all bytes are consumed.
  std::size_t room_for(std::size_t bytes) const noexcept {
    return (bytes / Decoder::kMinRecord + 2) * Decoder::kMaxPerRecord;
  }

  // Bytes of a record that waits for its end; > 0 at the end of the input: the file was cut.
  std::size_t unfinished() const noexcept { return cut_.size; }

  std::uint64_t bad_records() const noexcept { return bad_.count(); }
  std::span<const std::uint64_t> noted() const noexcept { return bad_.noted(); }
  std::uint64_t triggers() const noexcept { return triggers_; }

  // Events that came before what their time or place counts from: they are dropped.
  std::uint64_t before_start() const noexcept { return before_start_; }

  // As new.
  void reset() noexcept { static_cast<Decoder&>(*this) = Decoder(config_); }

 protected:
  static constexpr std::size_t kMinRecord = kRecord;  // bytes of the shortest one with an event

  explicit NativeDecoder(const Config& config, std::uint64_t first_offset = 0) noexcept
      : config_(config), offset_(first_offset) {}

  // Another record follows one that is not finished, which is bad.
  void drop_unfinished() noexcept {
    if (cut_.size == 0) return;
    bad_.add(offset_);
    offset_ += cut_.size;
    cut_.size = 0;
  }

  Config config_;
  std::uint64_t offset_;  // place of the next word or packet in the file
  std::uint64_t triggers_ = 0;
  std::uint64_t before_start_ = 0;
  BadRecords bad_;
  CutRecord<kRecord> cut_;

 private:
  Progress decode_to(Output out, std::span<const std::byte> bytes) noexcept;
};

}  // namespace asap::inline v0_1
