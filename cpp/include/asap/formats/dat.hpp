// DatDecoder: events of a Prophesee DAT file, 8 bytes each.
//
// t in us, 32 bits; then version 2: x 13:0, y 27:14, p 31:28; version 1: x 8:0, y 16:9, p 17. Types
// 0 and 12 are both change detections. Times unwrap every 2^32 us, where they fall by more than
// half of it. Any 8 bytes are an event: none are bad; polarity is the Validator's.
//
// One thread. Never throws, never allocates. O(bytes).
#pragma once

#include <optional>

#include "asap/core/event.hpp"
#include "asap/formats/progress.hpp"
#include "asap/formats/raw_header.hpp"

namespace asap {

struct DatConfig {
  int version = 2;
  std::uint64_t first_offset = 0;  // offset in the file of the first byte that is fed
};

struct DatHeader {
  std::size_t size = 0;  // bytes, type and size of an event included
  int version = 2;       // where it is not stated, the first events decide
  std::uint8_t type = 0;
  std::uint8_t event_size = 0;  // bytes
  std::uint16_t width = 0;      // px; 0: not stated
  std::uint16_t height = 0;
};

// Nothing if `bytes` do not begin with a header of text lines and two bytes.
std::optional<DatHeader> read_dat_header(std::span<const std::byte> bytes) noexcept;

class DatDecoder : public NativeDecoder<DatDecoder, DatConfig, 8> {
 public:
  static constexpr std::size_t kMostPerRecord = 1;  // events

  explicit DatDecoder(DatConfig config = {});

 private:
  friend NativeDecoder;

  std::size_t decode_words(const std::byte* first, std::size_t count, Output& out) noexcept;
  template <int kVersion>
  std::size_t decode_version(const std::byte* first, std::size_t count, Output& out) noexcept;

  std::int64_t t_ = 0;  // us, of the last event, unwrapped
};

}  // namespace asap
