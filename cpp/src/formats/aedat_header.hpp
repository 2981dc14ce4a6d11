// The header of AEDAT files: lines of text that begin with '#', and the sensors that they name.
// Any thread, no allocation, O(bytes).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "asap/formats/aedat.hpp"

namespace asap::inline v0_1 {

struct AedatSensor {
  int width, height;          // px; 0 where the name does not say
  Aedat2Chip chip;            // other: jAER writes its addresses in another way, or it is unknown
  std::uint32_t camera_bits;  // as in Aedat2Header
};

// The sensor whose name stands in `device`, in whatever case, such as "DAVIS FX2" or the name of a
// class of jAER.
AedatSensor aedat_sensor(std::string_view device) noexcept;

inline std::string_view text_of(std::span<const std::byte> bytes) noexcept {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// The first line of `text` with its end, which is empty where the line is none: it does not begin
// with '#', or holds what no text does, as a record that begins with '#' (0x23). Nothing where
// `text` ends inside the line.
std::optional<std::string_view> aedat_line(std::string_view text) noexcept;

}  // namespace asap::inline v0_1
