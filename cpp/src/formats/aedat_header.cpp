#include "formats/aedat_header.hpp"

#include <algorithm>

namespace asap {

namespace {

struct NamedSensor {
  std::string_view name;  // small letters
  std::uint16_t width, height;
};

// Longer names before those that they contain.
constexpr NamedSensor kSensors[] = {
    {"davisrgbw640", 640, 480}, {"davishet640", 640, 480}, {"davis640", 640, 480},
    {"davis346", 346, 260},     {"davis240", 240, 180},    {"davis208", 208, 192},
    {"davis128", 128, 128},     {"dvs128", 128, 128},      {"edvs4337", 128, 128},
    {"secdvs", 0, 0},           {"dvs640", 640, 480},      {"dvs132s", 132, 104},
    {"dvxplorer", 640, 480},
};

bool contains(std::string_view text, std::string_view small) noexcept {
  const auto same = [](char a, char b) { return (a >= 'A' && a <= 'Z' ? a + 32 : a) == b; };
  return std::search(text.begin(), text.end(), small.begin(), small.end(), same) != text.end();
}

}  // namespace

AedatSensor aedat_sensor(std::string_view device) noexcept {
  AedatSensor sensor{.is_davis = contains(device, "davis"),
                     .is_dvs128 = contains(device, "dvs128"),
                     .is_dvs640 = contains(device, "dvs640") && !contains(device, "secdvs"),
                     .is_multi = contains(device, "multi"),
                     .width = 0,
                     .height = 0};
  for (const NamedSensor& known : kSensors) {
    if (!contains(device, known.name)) continue;
    sensor.width = known.width;
    sensor.height = known.height;
    break;
  }
  return sensor;
}

std::optional<std::string_view> aedat_line(std::string_view text) noexcept {
  if (text.empty()) return {};
  if (text[0] != '#') return text.substr(0, 0);
  const auto end = std::ranges::find_if(
      text, [](char c) { return static_cast<unsigned char>(c) < ' ' && c != '\t' && c != '\r'; });
  if (end == text.end()) return {};
  if (*end != '\n') return text.substr(0, 0);
  return text.substr(0, static_cast<std::size_t>(end - text.begin()) + 1);
}

}  // namespace asap
