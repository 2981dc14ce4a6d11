#include "asap/formats/aedat.hpp"

#include <bit>

#include "core/check.hpp"
#include "formats/aedat_header.hpp"
#include "formats/records.hpp"
#include "formats/words.hpp"

namespace asap {

namespace {

// A record is a word: the address above, the time below.
template <class Address>
struct Aedat2 {
  static constexpr std::size_t kRecord = 8;
  static constexpr bool kBigEndian = true;

  std::uint32_t right, bottom;        // the highest x and y
  std::uint32_t camera_bits, camera;  // the second within the first
  std::uint64_t triggers;
  std::int64_t t;

  static std::size_t size(std::uint64_t) noexcept { return kRecord; }
  bool is_event(std::uint64_t word) const noexcept {
    return (word >> 32 & (Address::kOther | camera_bits)) == camera;
  }
  bool is_trigger(std::uint64_t word) const noexcept {
    return Address::is_trigger(static_cast<std::uint32_t>(word >> 32) & ~camera_bits);
  }
  bool waits(std::uint64_t word, const Output& out) const noexcept {
    return is_trigger(word) && !out.has_room_for_a_trigger();
  }
  std::size_t take(std::uint64_t word, Event* to, Output& out) noexcept {
    const auto address = static_cast<std::uint32_t>(word >> 32);
    // The 32 bits wrap: the shorter way from the last time is the right one.
    const auto step = static_cast<std::uint32_t>(word) - static_cast<std::uint32_t>(t);
    t += static_cast<std::int32_t>(step);
    if (is_trigger(word)) {
      ++triggers;
      out.take({.t = t, .id = 0, .value = 1});
    }
    write_event(to, (right - Address::x(address)) & 0xffff, (bottom - Address::y(address)) & 0xffff,
                Address::p(address), t);
    return is_event(word);
  }
};

struct Davis {
  static constexpr std::uint32_t kOther = 0x8000'0400;
  static std::uint32_t x(std::uint32_t address) noexcept { return address >> 12 & 0x3ff; }
  static std::uint32_t y(std::uint32_t address) noexcept { return address >> 22 & 0x1ff; }
  static std::uint32_t p(std::uint32_t address) noexcept { return address >> 11 & 1; }
  static bool is_trigger(std::uint32_t address) noexcept { return (address & kOther) == 0x400; }
};

struct Dvs128 {
  static constexpr std::uint32_t kOther = 0x8000'8000;
  static std::uint32_t x(std::uint32_t address) noexcept { return address >> 1 & 0x7f; }
  static std::uint32_t y(std::uint32_t address) noexcept { return address >> 8 & 0x7f; }
  static std::uint32_t p(std::uint32_t address) noexcept { return ~address & 1; }
  static bool is_trigger(std::uint32_t address) noexcept { return (address & kOther) != 0; }
};

template <unsigned kBitsOfX, unsigned kBitsOfY>
struct Dvs {
  static constexpr std::uint32_t kOther = ~0u << (1 + kBitsOfX + kBitsOfY);
  static std::uint32_t x(std::uint32_t address) noexcept {
    return address >> 1 & ~(~0u << kBitsOfX);
  }
  static std::uint32_t y(std::uint32_t address) noexcept {
    return address >> (1 + kBitsOfX) & ~(~0u << kBitsOfY);
  }
  static std::uint32_t p(std::uint32_t address) noexcept { return address & 1; }
  static bool is_trigger(std::uint32_t) noexcept { return false; }
};

unsigned shift_of(std::uint32_t bits) noexcept {
  return bits == 0 ? 0 : static_cast<unsigned>(std::countr_zero(bits));
}

// Addresses of a DVS128 have 16 bits; those of a DAVIS are mostly longer.
bool are_of_a_dvs128(std::string_view records) noexcept {
  if (records.size() < 8) return false;
  for (; records.size() >= 8; records.remove_prefix(8)) {
    if ((records[0] & 0x7f) != 0 || records[1] != 0) return false;
  }
  return true;
}

}  // namespace

std::optional<Aedat2Header> read_aedat2_header(std::span<const std::byte> front) noexcept {
  const std::string_view text(reinterpret_cast<const char*>(front.data()), front.size());
  if (!text.starts_with("#!AER-DAT2.0")) return {};
  std::string_view device;  // the chip's class is better than the camera's name
  bool is_chip = false;
  std::size_t at = 0;
  while (at < text.size()) {
    const std::optional<std::string_view> line = aedat_line(text.substr(at));
    if (!line) return {};
    if (line->empty()) break;
    at += line->size();
    if (line->find("End Of ASCII") != line->npos) break;
    const bool names_chip = line->starts_with("# AEChip:");
    if (names_chip || (!is_chip && line->starts_with("# HardwareInterface:"))) {
      device = line->substr(line->find(':') + 1);
      is_chip = names_chip;
    }
  }
  const AedatSensor sensor = aedat_sensor(device);
  Aedat2Header header{at, sensor.chip, sensor.width, sensor.height, sensor.camera_bits};
  if (sensor.chip == Aedat2Chip::other && !is_chip) {
    const bool is_dvs128 = are_of_a_dvs128(text.substr(at));
    header.chip = is_dvs128 ? Aedat2Chip::dvs128 : Aedat2Chip::unnamed;
  }
  return header;
}

Aedat2Decoder::Aedat2Decoder(const Aedat2Config& config) : NativeDecoder(config) {
  const Aedat2Chip chip = config.chip;
  require(chip != Aedat2Chip::unnamed && chip != Aedat2Chip::other && chip <= Aedat2Chip::dvs1280,
          "chip", static_cast<int>(chip), "davis, dvs128, dvs640 or dvs1280");
  require(config.camera <= config.camera_bits >> shift_of(config.camera_bits), "camera",
          config.camera, "a number that camera_bits hold");
  const int widest = chip == Aedat2Chip::dvs128 ? 128 : chip == Aedat2Chip::dvs1280 ? 2048 : 1024;
  const int highest = chip == Aedat2Chip::dvs128 ? 128 : widest / 2;
  require(config.width >= 1 && config.width <= widest, "width", config.width,
          "the sensor's, within the bits of an address");
  require(config.height >= 1 && config.height <= highest, "height", config.height,
          "the sensor's, within the bits of an address");
}

std::size_t Aedat2Decoder::decode_bytes(std::span<const std::byte> bytes, Output& out) noexcept {
  const auto run = [&](auto format) {
    const std::size_t used = records::decode_records(format, cut_, bytes, out);
    triggers_ = format.triggers;
    t_ = format.t;
    return used;
  };
  const auto right = static_cast<std::uint32_t>(config_.width - 1);
  const auto bottom = static_cast<std::uint32_t>(config_.height - 1);
  const std::uint32_t bits = config_.camera_bits, camera = config_.camera << shift_of(bits);
  const auto decode = [&]<class Address>(Address) {
    return run(Aedat2<Address>{right, bottom, bits, camera, triggers_, t_});
  };
  if (config_.chip == Aedat2Chip::dvs128) return decode(Dvs128{});
  if (config_.chip == Aedat2Chip::dvs640) return decode(Dvs<10, 9>{});
  return config_.chip == Aedat2Chip::dvs1280 ? decode(Dvs<11, 10>{}) : decode(Davis{});
}

template class NativeDecoder<Aedat2Decoder, Aedat2Config, 8>;

}  // namespace asap
