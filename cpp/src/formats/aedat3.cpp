#include "asap/formats/aedat.hpp"

#include <array>
#include <charconv>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "core/check.hpp"
#include "formats/aedat_header.hpp"
#include "formats/opener.hpp"
#include "formats/records.hpp"
#include "formats/words.hpp"

namespace asap::inline v0_1 {

namespace {

// A record is a word: the data below, the time above.
struct PolarityEvents {
  static constexpr std::size_t kRecord = 8;
  static constexpr bool kBigEndian = false;

  std::int64_t overflow_us;
  std::uint64_t invalid = 0;

  static std::size_t size(std::uint64_t) noexcept { return kRecord; }
  static bool is_event(std::uint64_t word) noexcept { return (word & 1) != 0; }
  static bool waits(std::uint64_t, const Output&) noexcept { return false; }
  std::size_t take(std::uint64_t word, Event* to, Output&) noexcept {
    write_event(to, word >> 17 & 0x7fff, word >> 2 & 0x7fff, word >> 1 & 1,
                overflow_us | static_cast<std::int64_t>(word >> 32));
    invalid += ~word & 1;
    return word & 1;
  }
};

struct SpecialEvents {
  static constexpr std::size_t kRecord = 8;
  static constexpr bool kBigEndian = false;
  static constexpr std::uint64_t kRisingEdge = 2, kFallingEdge = 3, kPulse = 4;

  std::int64_t overflow_us;
  std::uint64_t triggers = 0;

  static bool is_trigger(std::uint64_t word) noexcept {
    const std::uint64_t type = word >> 1 & 0x7f;
    return (word & 1) != 0 && type >= kRisingEdge && type <= kPulse;
  }
  static std::size_t size(std::uint64_t) noexcept { return kRecord; }
  static bool is_event(std::uint64_t) noexcept { return false; }
  static bool waits(std::uint64_t word, const Output& out) noexcept {
    return is_trigger(word) && !out.has_room_for_a_trigger();
  }
  std::size_t take(std::uint64_t word, Event*, Output& out) noexcept {
    if (is_trigger(word)) {
      const bool rises = (word >> 1 & 0x7f) != kFallingEdge;
      out.take({.t = overflow_us | static_cast<std::int64_t>(word >> 32), .id = 0, .value = rises});
      ++triggers;
    }
    return 0;
  }
};

struct PacketHeader {
  std::int16_t type, source;
  std::int32_t event_size, time_at, overflows, capacity, events, valid;
};

PacketHeader read_packet_header(const std::byte* from) noexcept {
  const auto i16 = [&](std::size_t at) {
    return static_cast<std::int16_t>(records::load<false>(from + at, 2));
  };
  const auto i32 = [&](std::size_t at) {
    return static_cast<std::int32_t>(records::load<false>(from + at, 4));
  };
  return {i16(0), i16(2), i32(4), i32(8), i32(12), i32(16), i32(20), i32(24)};
}

constexpr std::int16_t kSpecial = 0, kPolarity = 1;

bool is_possible(const PacketHeader& header) noexcept {
  const bool has_words = header.type == kSpecial || header.type == kPolarity;
  return header.type >= 0 && header.source >= 0 && header.event_size > 0 && header.time_at >= 0 &&
         header.time_at < header.event_size && header.overflows >= 0 && header.valid >= 0 &&
         header.valid <= header.events && header.events <= header.capacity &&
         (!has_words || (header.event_size == 8 && header.time_at == 4));
}

}  // namespace

std::optional<Aedat3Header> read_aedat3_header(std::span<const std::byte> front) noexcept {
  const std::string_view text = text_of(front);
  if (!Aedat3Decoder::begins(front)) return {};
  Aedat3Header header{.size = 0, .raw = true, .sources = 0, .width = 0, .height = 0};
  while (true) {
    const std::optional<std::string_view> line = aedat_line(text.substr(header.size));
    if (!line || line->empty()) return {};
    header.size += line->size();
    if (line->starts_with("#!END-HEADER")) return header;
    if (line->starts_with("#Format:")) header.raw = line->find(" RAW") != line->npos;
    if (line->starts_with("#Source ") && header.sources++ == 0) {
      const AedatSensor sensor = aedat_sensor(*line);
      header.width = sensor.width;
      header.height = sensor.height;
    }
  }
}

// ---- opening ----

namespace {

// What the lines "#Source 1: DAVIS346" call the cameras.
std::map<int, std::string> named_sources(std::string_view header) {
  constexpr std::string_view kKey = "#Source ";
  std::map<int, std::string> names;
  for (std::size_t at = 0; at < header.size();) {
    const std::string_view line = header.substr(at, header.find('\n', at) - at);
    at += line.size() + 1;
    const std::size_t colon = line.find(':');
    if (!line.starts_with(kKey) || colon == line.npos) continue;
    int number = 0;
    const auto* const end = line.data() + colon;
    if (std::from_chars(line.data() + kKey.size(), end, number).ptr != end) continue;
    const std::size_t from = line.find_first_not_of(' ', colon + 1);
    const std::size_t last = line.find_last_not_of(" \r");
    names[number] = from == line.npos ? "" : line.substr(from, last + 1 - from);
  }
  return names;
}

// The cameras that have events, by the headers of whole packets.
std::set<int> sources_in(const std::filesystem::path& path, std::size_t start) {
  std::set<int> found;
  std::ifstream file(path, std::ios::binary);
  file.seekg(static_cast<std::streamoff>(start));
  std::array<std::byte, 28> head;
  while (file.read(reinterpret_cast<char*>(head.data()), head.size())) {
    const PacketHeader packet = read_packet_header(head.data());
    if (packet.event_size < 0 || packet.events < 0 || packet.events > packet.capacity) break;
    if (packet.type == kPolarity && packet.events > 0) found.insert(packet.source);
    file.seekg(std::streamoff{packet.event_size} * packet.events, std::ios::cur);
  }
  return found;
}

}  // namespace

bool Aedat3Decoder::begins(std::span<const std::byte> front) noexcept {
  return text_of(front).starts_with("#!AER-DAT3.1");
}

OpenedRecording Aedat3Decoder::open(const RecordingFile& file) {
  const auto header = read_aedat3_header(file.front);
  if (!header) file.corrupt("no whole header of AEDAT 3.1: '#!END-HEADER' is missing");
  if (!header->raw) file.unsupported("compressed AEDAT 3.1 is not read; '#Format: RAW' is");
  const std::map<int, std::string> names = named_sources(text_of(file.front.first(header->size)));
  const std::set<int> found = sources_in(file.path, header->size);
  OpenedRecording opened{.start = header->size, .width = header->width, .height = header->height};
  std::vector<int> sources{-1};
  if (found.size() > 1) {
    sources.assign(found.begin(), found.end());
    for (const int source : sources) {
      const auto named = names.find(source);
      const bool has_size = named != names.end() && named->second == names.begin()->second;
      const std::string number = std::to_string(source);
      const std::string name = named == names.end() ? "not named" : named->second;
      opened.streams.push_back({number, number + " (" + name + ")", has_size ? header->width : 0,
                                has_size ? header->height : 0});
    }
  }
  opened.make = [sources](std::uint64_t at, std::size_t stream) {
    return Aedat3Decoder({.source = sources.at(stream), .first_offset = at});
  };
  return opened;
}

Aedat3Decoder::Aedat3Decoder(const Aedat3Config& config)
    : NativeDecoder(config, config.first_offset) {
  require(config.source >= -1 && config.source <= 0x7fff, "source", config.source,
          "the number of a camera, or -1 for all");
}

std::size_t Aedat3Decoder::decode_bytes(std::span<const std::byte> bytes, Output& out) noexcept {
  std::size_t used = 0;
  while (used < bytes.size()) {
    const auto rest = bytes.subspan(used);
    const std::size_t step = packet_left_ > 0 ? take_packet(rest, out) : take_header(rest);
    if (step == 0) break;  // no room for what comes next
    used += step;
  }
  return used;
}

// Both return how many of `bytes` they consumed; a header needs no room.

std::size_t Aedat3Decoder::take_packet(std::span<const std::byte> bytes, Output& out) noexcept {
  std::size_t used = static_cast<std::size_t>(std::min<std::uint64_t>(bytes.size(), packet_left_));
  bytes = bytes.first(used);
  if (packet_ == Packet::polarity) {
    PolarityEvents format{overflow_us_};
    used = records::decode_records(format, cut_, bytes, out);
    invalid_ += format.invalid;
  } else if (packet_ == Packet::special) {
    SpecialEvents format{overflow_us_};
    used = records::decode_records(format, cut_, bytes, out);
    triggers_ += format.triggers;
  }
  packet_left_ -= used;
  offset_ += used;
  return used;
}

std::size_t Aedat3Decoder::take_header(std::span<const std::byte> bytes) noexcept {
  const std::size_t taken = std::min(kHeader - cut_.size, bytes.size());
  std::memcpy(cut_.bytes.data() + cut_.size, bytes.data(), taken);
  cut_.size += taken;
  offset_ += taken;
  if (cut_.size < kHeader) return taken;
  const PacketHeader header = read_packet_header(cut_.bytes.data());
  if (!is_possible(header) || (lost_ && header.type != kPolarity)) {
    if (!lost_) bad_.add(offset_ - kHeader);
    lost_ = true;
    std::memmove(cut_.bytes.data(), cut_.bytes.data() + 1, kHeader - 1);
    cut_.size = kHeader - 1;
    return taken;
  }
  lost_ = false;
  cut_.size = 0;
  const bool wanted = config_.source < 0 || config_.source == header.source;
  packet_ = !wanted                    ? Packet::other
            : header.type == kPolarity ? Packet::polarity
            : header.type == kSpecial  ? Packet::special
                                       : Packet::other;
  overflow_us_ = static_cast<std::int64_t>(header.overflows) << 31;
  packet_at_ = offset_ - kHeader;
  packet_left_ =
      static_cast<std::uint64_t>(header.events) * static_cast<std::uint64_t>(header.event_size);
  return taken;
}

template class NativeDecoder<Aedat3Decoder, Aedat3Config, 28>;

}  // namespace asap::inline v0_1
