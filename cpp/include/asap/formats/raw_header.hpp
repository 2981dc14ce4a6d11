// read_raw_header: the text before the words of a Prophesee RAW or DAT file.
//
// Lines "% key value", each ended by a newline, up to "% end" or the first line of another kind.
// Keys: evt 2.0 | 2.1 | 3.0 (old); format EVT3;height=720;width=1280 (new, counts more), geometry
// 1280x720, endianness, plugin_name (of old recordings, names the sensor). DAT: Version, Width,
// Height, then two bytes, type and size of an event; read_dat_header (dat.hpp) reads them.
//
// Any thread. O(size of the header), no allocation. Numbers that are absurd count as absent.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace asap {

struct RawHeader {
  enum class Words : std::uint8_t { unknown, evt2, evt21, evt3 };

  std::size_t size = 0;  // bytes; the first word begins there
  Words words = Words::unknown;
  bool little_endian = false;  // said so; EVT2.1 swaps the halves of its words otherwise
  bool is_dat = false;         // "Data file containing ..."
  int version = -1;            // of a DAT file; -1: not stated
  std::uint16_t width = 0;     // px; 0: not stated
  std::uint16_t height = 0;
};

// Nothing if `bytes` do not begin with such a line. Give enough bytes: a header that is cut ends
// where they end.
std::optional<RawHeader> read_raw_header(std::span<const std::byte> bytes) noexcept;

}  // namespace asap
