// The header of AEDAT files: lines of text that begin with '#', and the sensors that they name.
// Any thread, no allocation, O(bytes).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

namespace asap {

struct AedatSensor {
  bool is_davis, is_dvs128, is_dvs640;
  bool is_multi;                // several cameras in one
  std::uint16_t width, height;  // px; 0 where the name does not say
};

// The sensor whose name stands in `device`, in whatever case, such as "DAVIS FX2" or the name of a
// class of jAER.
AedatSensor aedat_sensor(std::string_view device) noexcept;

// The first line of `text` with its end, which is empty where the line is none: it does not begin
// with '#', or holds what no text does, as a record that begins with '#' (0x23). Nothing where
// `text` ends inside the line.
std::optional<std::string_view> aedat_line(std::string_view text) noexcept;

}  // namespace asap
