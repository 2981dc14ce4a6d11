#include "asap/formats/prophesee.hpp"

#include "core/check.hpp"
#include "formats/opener.hpp"
#include "formats/words.hpp"

namespace asap::inline v0_1 {

namespace {

constexpr std::int64_t kDatRange = std::int64_t{1} << 32;  // us
constexpr std::size_t kDatEvent = 8;                       // bytes
constexpr std::size_t kDatProbe = 65536;                   // bytes

std::uint32_t dat_address(const std::byte* first, std::size_t i) noexcept {
  return load_little<std::uint32_t>(first + i * kDatEvent + 4);
}

// Version 1 leaves the upper 14 bits free.
int version_of(std::span<const std::byte> events) noexcept {
  std::uint32_t all = 0;
  for (std::size_t i = 0; i < std::min(events.size(), kDatProbe) / kDatEvent; ++i) {
    all |= dat_address(events.data(), i);
  }
  return all != 0 && all >> 18 == 0 ? 1 : 2;
}

bool is_of_pixels(const DatHeader& header) noexcept {
  return (header.type == 0 || header.type == 12) && header.event_size == kDatEvent;
}

}  // namespace

std::optional<DatHeader> read_dat_header(std::span<const std::byte> bytes) noexcept {
  const auto text = read_raw_header(bytes);
  if (!text || text->words != RawHeader::Words::unknown || bytes.size() < text->size + 2) {
    return std::nullopt;
  }
  DatHeader header{.size = text->size + 2,
                   .version = text->version,
                   .type = static_cast<std::uint8_t>(bytes[text->size]),
                   .event_size = static_cast<std::uint8_t>(bytes[text->size + 1]),
                   .width = text->width,
                   .height = text->height};
  if (!text->is_dat && header.event_size != kDatEvent) return std::nullopt;
  if (header.type == '%') return std::nullopt;  // a header line that is cut
  if (header.version < 0) header.version = version_of(bytes.subspan(header.size));
  return header;
}

bool DatDecoder::begins(std::span<const std::byte> front) noexcept {
  const auto text = read_raw_header(front);
  if (!text || text->words != RawHeader::Words::unknown) return false;
  const auto header = read_dat_header(front);
  return text->is_dat || (header && is_of_pixels(*header));
}

OpenedRecording DatDecoder::open(const RecordingFile& file) {
  const auto header = read_dat_header(file.front);
  if (!header) file.corrupt("no header of text lines with type and size of an event");
  const int type = header->type, version = header->version;
  if (!is_of_pixels(*header)) {
    file.unsupported("DAT with events of type " + std::to_string(type) + " and " +
                     std::to_string(header->event_size) +
                     " bytes: only the types 0 and 12 of 8 bytes are events of pixels");
  }
  if (version != 1 && version != 2) {
    file.unsupported("DAT of version " + std::to_string(version) + "; what is read: 1 and 2");
  }
  return {.start = header->size,
          .width = header->width,
          .height = header->height,
          .make = [=](std::uint64_t at,
                      std::size_t) { return DatDecoder({.version = version, .first_offset = at}); },
          .entry = [](std::span<const std::byte> piece) -> std::optional<Entry> {
            if (piece.size() < kDatEvent) return std::nullopt;
            return Entry{0, load_little<std::uint32_t>(piece.data())};
          }};
}

DatDecoder::DatDecoder(DatConfig config) : NativeDecoder(config, config.first_offset) {
  require(config.version == 1 || config.version == 2, "version", config.version, "use 1 or 2");
}

std::size_t DatDecoder::decode_words(const std::byte* first, std::size_t count,
                                     Output& out) noexcept {
  return config_.version == 1 ? decode_version<1>(first, count, out)
                              : decode_version<2>(first, count, out);
}

template <int kVersion>
std::size_t DatDecoder::decode_version(const std::byte* first, std::size_t count,
                                       Output& out) noexcept {
  const std::size_t end = std::min(count, out.room());
  Event* event = out.event;
  std::int64_t t = t_;
  for (std::size_t i = 0; i < end; ++i) {
    t = unwrapped(t, load_little<std::uint32_t>(first + i * kDatEvent), kDatRange);
    const std::uint64_t address = dat_address(first, i);
    if constexpr (kVersion == 1) {
      write_event(event++, address & 0x1ff, address >> 9 & 0xff, address >> 17 & 1, t);
    } else {
      write_event(event++, address & 0x3fff, address >> 14 & 0x3fff, address >> 28, t);
    }
  }
  out.event = event;
  t_ = t;
  return end;
}

template class NativeDecoder<DatDecoder, DatConfig, 8>;

}  // namespace asap::inline v0_1
