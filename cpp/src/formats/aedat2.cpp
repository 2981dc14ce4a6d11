#include "asap/formats/aedat.hpp"

#include <algorithm>
#include <bit>
#include <fstream>
#include <string>
#include <vector>

#include "core/check.hpp"
#include "formats/aedat_header.hpp"
#include "formats/opener.hpp"
#include "formats/records.hpp"
#include "formats/words.hpp"

namespace asap::inline v0_1 {

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
    t = unwrapped(t, static_cast<std::uint32_t>(word), std::int64_t{1} << 32);
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
  const std::string_view text = text_of(front);
  if (!Aedat2Decoder::begins(front)) return {};
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

// ---- opening ----

namespace {

struct KnownSize {
  int width, height;
  std::string_view name;
  Aedat2Chip chip;
};

constexpr KnownSize kSizes[] = {
    {240, 180, "davis", Aedat2Chip::davis},      {346, 260, "davis", Aedat2Chip::davis},
    {208, 192, "davis", Aedat2Chip::davis},      {640, 480, "dvs640", Aedat2Chip::dvs640},
    {1280, 720, "dvs1280", Aedat2Chip::dvs1280}, {128, 128, "davis", Aedat2Chip::davis},
};  // a DVS128 is known by its addresses

// Tells the chip by its size: 640 x 480 is a DVXplorer where the addresses are too long for a
// DVS640.
Aedat2Chip chip_of_size(int width, int height, std::span<const std::byte> records) noexcept {
  const auto* const known = std::ranges::find_if(
      kSizes, [&](const KnownSize& size) { return size.width == width && size.height == height; });
  if (known == std::end(kSizes)) return Aedat2Chip::unnamed;
  if (known->chip != Aedat2Chip::dvs640) return known->chip;
  std::size_t longer = 0;
  for (std::size_t at = 0; at + 8 <= records.size(); at += 8) {
    longer += load_big<std::uint32_t>(records.data() + at) >> 21 != 0;
  }
  return 2 * longer > records.size() / 8 ? Aedat2Chip::davis : Aedat2Chip::dvs640;
}

// The numbers of the cameras that have events; reads the whole file.
std::vector<std::uint32_t> cameras_in(const RecordingFile& file, std::uint64_t start,
                                      Aedat2Chip chip, std::uint32_t bits) {
  const std::uint32_t no_event = chip == Aedat2Chip::davis ? 0x8000'0400 : 0x8000'8000 & ~bits;
  std::vector<bool> seen(std::size_t{1} << std::popcount(bits));
  std::ifstream in(file.path, std::ios::binary);
  in.seekg(static_cast<std::streamoff>(start));
  std::vector<char> piece(1 << 20);
  while (in.read(piece.data(), std::ssize(piece)), in.gcount() > 0) {
    for (std::ptrdiff_t at = 0; at + 8 <= in.gcount(); at += 8) {
      const std::uint32_t address =
          load_big<std::uint32_t>(reinterpret_cast<const std::byte*>(piece.data() + at));
      if ((address & no_event) == 0) seen[(address & bits) >> shift_of(bits)] = true;
    }
  }
  std::vector<std::uint32_t> cameras;
  for (std::uint32_t i = 0; i < seen.size(); ++i) {
    if (seen[i]) cameras.push_back(i);
  }
  if (cameras.empty()) cameras.push_back(0);
  return cameras;
}

}  // namespace

bool Aedat2Decoder::begins(std::span<const std::byte> front) noexcept {
  return text_of(front).starts_with("#!AER-DAT2.0");
}

OpenedRecording Aedat2Decoder::open(const RecordingFile& file) {
  constexpr std::uint32_t kRightOfTwo = 0x8000;  // marks the right one of a stereo pair
  const auto header = read_aedat2_header(file.front);
  if (!header) file.corrupt("no whole header of AEDAT 2.0");
  Aedat2Config config{.chip = header->chip,
                      .width = header->width > 0 ? header->width : file.config.width,
                      .height = header->height > 0 ? header->height : file.config.height,
                      .camera_bits = header->camera_bits};
  if (config.chip == Aedat2Chip::other) {
    file.unsupported(
        "AEDAT 2.0 is read of a DAVIS, a DVXplorer, a DVS128, a DVS640 or a DVS1280x720SD; the "
        "header names another chip");
  }
  if (config.chip == Aedat2Chip::dvs128 && header->width == 0) {  // so say its addresses
    if (config.width == 0) config.width = 128;
    if (config.height == 0) config.height = 128;
    if (config.width != 128 || config.height != 128) config.chip = Aedat2Chip::unnamed;
  }
  if (config.chip == Aedat2Chip::unnamed) {
    config.chip = chip_of_size(config.width, config.height, file.front.subspan(header->size));
  }
  if (config.chip == Aedat2Chip::unnamed || config.width == 0 || config.height == 0) {
    std::string known;
    for (const KnownSize& size : kSizes) {
      known.append(known.empty() ? "" : ", ")
          .append(std::to_string(size.width) + " x " + std::to_string(size.height) + " (")
          .append(size.name)
          .append(")");
    }
    file.unsupported(
        "the header of this AEDAT 2.0 file does not say which chip it is of, and the layout of its "
        "addresses depends on it; give width and height, one of " +
        known);
  }
  OpenedRecording opened{.start = header->size, .width = config.width, .height = config.height};
  const auto add = [&](const std::string& name) {
    opened.streams.push_back({name, name, config.width, config.height});
  };
  std::vector<std::uint32_t> cameras{0};
  if (config.camera_bits == kRightOfTwo) {
    cameras = {0, 1};
    add("left");
    add("right");
  } else if (config.camera_bits != 0) {
    cameras = cameras_in(file, header->size, config.chip, config.camera_bits);
    for (const std::uint32_t camera : cameras) add(std::to_string(camera));
  }
  opened.make = [config, cameras](std::uint64_t, std::size_t stream) {
    Aedat2Config its = config;
    its.camera = cameras.at(stream);
    return Aedat2Decoder(its);
  };
  return opened;
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

}  // namespace asap::inline v0_1
