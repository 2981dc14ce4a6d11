#include "formats/aedat_header.hpp"

#include <algorithm>

namespace asap::inline v0_1 {

namespace {

struct NamedSensor {
  std::string_view name;  // small letters
  int width, height;
  Aedat2Chip chip = Aedat2Chip::other;
};

// Longer names before those that they contain.
constexpr NamedSensor kSensors[] = {
    {"davisrgbw640", 640, 480, Aedat2Chip::davis},
    {"davishet640", 640, 480, Aedat2Chip::davis},
    {"davis640", 640, 480, Aedat2Chip::davis},
    {"davis346", 346, 260, Aedat2Chip::davis},
    {"davis240", 240, 180, Aedat2Chip::davis},
    {"davis208", 208, 192, Aedat2Chip::davis},
    {"davis128", 128, 128, Aedat2Chip::davis},
    {"davis", 0, 0, Aedat2Chip::davis},
    {"dvs1280", 1280, 720, Aedat2Chip::dvs1280},
    {"dvs128", 128, 128, Aedat2Chip::dvs128},
    {"edvs4337", 128, 128},
    {"secdvs", 0, 0},
    {"dvs640", 640, 480, Aedat2Chip::dvs640},
    {"dvs132s", 132, 104},
    {"dvxplorer", 640, 480, Aedat2Chip::davis},
};

bool contains(std::string_view text, std::string_view small) noexcept {
  const auto same = [](char a, char b) { return (a >= 'A' && a <= 'Z' ? a + 32 : a) == b; };
  return std::search(text.begin(), text.end(), small.begin(), small.end(), same) != text.end();
}

}  // namespace

AedatSensor aedat_sensor(std::string_view device) noexcept {
  const auto known = std::ranges::find_if(
      kSensors, [&](const NamedSensor& sensor) { return contains(device, sensor.name); });
  if (known == std::end(kSensors)) return {0, 0, Aedat2Chip::other, 0};
  AedatSensor sensor{known->width, known->height, known->chip, 0};
  const bool is_davis = known->chip == Aedat2Chip::davis;
  if (contains(device, "stereo")) {
    sensor.camera_bits = 0x8000;
    if (is_davis) sensor.chip = Aedat2Chip::other;
  } else if (contains(device, "multi")) {
    sensor.camera_bits = is_davis ? 0xf : 0xff00'0000;
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

}  // namespace asap::inline v0_1
