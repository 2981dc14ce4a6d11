#include "asap/formats/atis.hpp"

#include <array>
#include <string_view>

#include "core/check.hpp"
#include "formats/opener.hpp"
#include "formats/records.hpp"
#include "formats/words.hpp"

namespace asap::inline v0_1 {

namespace {

constexpr std::string_view kSignature = "Event Stream";

struct EventStream1 {
  static constexpr std::size_t kRecord = 3;
  static constexpr bool kBigEndian = false;

  std::uint32_t bottom;  // the highest y
  std::int64_t t;

  static bool is_event(std::uint64_t word) noexcept { return (word & 15) != 15; }
  static bool waits(std::uint64_t, const Output&) noexcept { return false; }
  static std::size_t size(std::uint64_t word) noexcept { return is_event(word) ? kRecord : 1; }
  std::size_t take(std::uint64_t word, Event* to, Output&) noexcept {
    if (!is_event(word)) {
      t += static_cast<std::int64_t>((word >> 4 & 15) * 15);
      return 0;
    }
    t += static_cast<std::int64_t>(word & 15);
    write_event(to, word >> 4 & 0x3ff, (bottom - (word >> 14 & 0x1ff)) & 0xffff, word >> 23 & 1, t);
    return 1;
  }
};

struct EventStream2 {
  static constexpr std::size_t kRecord = 5;
  static constexpr bool kBigEndian = false;

  std::uint32_t bottom;  // the highest y
  std::int64_t t;

  static bool is_event(std::uint64_t word) noexcept { return (word & 0xff) < 0xfe; }
  static bool waits(std::uint64_t, const Output&) noexcept { return false; }
  static std::size_t size(std::uint64_t word) noexcept { return is_event(word) ? kRecord : 1; }
  std::size_t take(std::uint64_t word, Event* to, Output&) noexcept {
    if (!is_event(word)) {
      t += static_cast<std::int64_t>((word & 1) * 127);
      return 0;
    }
    t += static_cast<std::int64_t>(word >> 1 & 0x7f);
    write_event(to, word >> 8 & 0xffff, (bottom - (word >> 24)) & 0xffff, word & 1, t);
    return 1;
  }
};

EventStreamHeader::Type type_of(int version, unsigned byte) noexcept {
  using enum EventStreamHeader::Type;
  static constexpr std::array kVersion1{dvs, atis, display, color, generic};
  static constexpr std::array kVersion2{generic, dvs, atis, display, color};
  const auto& types = version == 1 ? kVersion1 : kVersion2;
  return byte < types.size() ? types[byte] : unknown;
}

}  // namespace

std::optional<EventStreamHeader> read_event_stream_header(
    std::span<const std::byte> front) noexcept {
  constexpr std::size_t kAt = kSignature.size();
  const auto byte = [&](std::size_t at) { return std::to_integer<unsigned>(front[at]); };
  if (front.size() < kAt + 3 || !EventStreamDecoder::begins(front)) return {};
  if (byte(kAt) == 1) {
    return EventStreamHeader{kAt + 3, 1, type_of(1, byte(kAt + 2)), 0, 0};
  }
  if (byte(kAt) != 2 || front.size() < kAt + 4) return {};
  EventStreamHeader header{kAt + 4, 2, type_of(2, byte(kAt + 3)), 0, 0};
  using enum EventStreamHeader::Type;
  if (header.type == dvs || header.type == atis || header.type == color) {
    if (front.size() < kAt + 8) return {};
    header.size = kAt + 8;
    const auto side = [&](std::size_t at) {
      return static_cast<int>(byte(at) | byte(at + 1) << 8);
    };
    header.width = side(kAt + 4);
    header.height = side(kAt + 6);
  }
  return header;
}

bool EventStreamDecoder::begins(std::span<const std::byte> front) noexcept {
  return front.size() >= kSignature.size() &&
         std::memcmp(front.data(), kSignature.data(), kSignature.size()) == 0;
}

OpenedRecording EventStreamDecoder::open(const RecordingFile& file) {
  const auto header = read_event_stream_header(file.front);
  if (!header) file.corrupt("no whole header of Event Stream 1 or 2");
  if (header->type != EventStreamHeader::Type::dvs) {
    static constexpr std::array kTypes{"generic", "dvs", "atis", "display", "color", "unknown"};
    file.unsupported(std::string("Event Stream of type ") +
                     kTypes[static_cast<std::size_t>(header->type)] + " is not read; type dvs is");
  }
  const int height = header->height > 0 ? header->height : file.config.height;
  if (height == 0) {
    file.unsupported(
        "this Event Stream does not state the height of its sensor, and its rows count from the "
        "bottom; give height in px, 240 for an ATIS");
  }
  return {.start = header->size,
          .width = header->width,
          .height = height,
          .event_bytes = 5,
          .make = [=, version = header->version](std::uint64_t, std::size_t) {
            return EventStreamDecoder({.version = version, .height = height});
          }};
}

EventStreamDecoder::EventStreamDecoder(const EventStreamConfig& config) : NativeDecoder(config) {
  require(config.version == 1 || config.version == 2, "version", config.version, "1 or 2");
  require(config.height > 0 && config.height <= 65'535, "height", config.height,
          "the sensor's in px: rows count from the bottom");
}

std::size_t EventStreamDecoder::decode_bytes(std::span<const std::byte> bytes,
                                             Output& out) noexcept {
  const auto run = [&](auto format) {
    const std::size_t used = records::decode_records(format, cut_, bytes, out);
    t_ = format.t;
    return used;
  };
  const auto bottom = static_cast<std::uint32_t>(config_.height - 1);
  return config_.version == 1 ? run(EventStream1{bottom, t_}) : run(EventStream2{bottom, t_});
}

template class NativeDecoder<EventStreamDecoder, EventStreamConfig, 5>;

}  // namespace asap::inline v0_1
