#include "asap/formats/recording.hpp"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <fstream>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "asap/formats/aedat.hpp"
#include "asap/formats/atis.hpp"
#include "asap/formats/prophesee.hpp"
#include "core/check.hpp"

namespace asap {
namespace recording {

using Decoder = std::variant<TextDecoder, Evt2Decoder, Evt21Decoder, Evt3Decoder, DatDecoder,
                             Aedat2Decoder, Aedat3Decoder, EventStreamDecoder>;

struct Opened {
  Decoder decoder;
  std::size_t header = 0;  // bytes
  int width = 0;
  int height = 0;
};

}  // namespace recording

namespace {

using recording::Decoder;
using recording::Opened;
using Bytes = std::span<const std::byte>;

constexpr std::size_t kLongestHeader = std::size_t{1} << 20;  // bytes; jAER writes 170 kB

[[noreturn]] void refuse(const std::filesystem::path& path, std::string_view remedy) {
  throw_bad_value("path", path.string(), remedy);
}

std::optional<Opened> open_raw(const std::filesystem::path& path, Bytes front) {
  const std::optional<RawHeader> header = read_raw_header(front);
  if (!header) return std::nullopt;
  if (header->is_dat) {
    const std::optional<DatHeader> dat = read_dat_header(front);
    if (!dat || dat->event_size != 8) refuse(path, "is a DAT file without change detections");
    return Opened{DatDecoder({.version = dat->version, .first_offset = dat->size}), dat->size,
                  dat->width, dat->height};
  }
  const auto opened = [&](Decoder decoder) {
    return Opened{std::move(decoder), header->size, header->width, header->height};
  };
  switch (header->words) {
    case RawHeader::Words::evt2:
      return opened(Evt2Decoder({.first_offset = header->size}));
    case RawHeader::Words::evt21:
      return opened(
          Evt21Decoder({.little_endian = header->little_endian, .first_offset = header->size}));
    case RawHeader::Words::evt3:
      return opened(Evt3Decoder({.first_offset = header->size}));
    case RawHeader::Words::unknown:
      break;
  }
  refuse(path, "is a RAW file that names none of EVT2, EVT2.1 and EVT3");
}

std::optional<Opened> open_aedat(const std::filesystem::path& path, Bytes front) {
  if (const auto header = read_aedat2_header(front)) {
    const bool is_dvs128 = header->chip == Aedat2Chip::dvs128;  // maybe by its addresses
    if (header->chip == Aedat2Chip::other || (header->width == 0 && !is_dvs128)) {
      refuse(path, "is an AEDAT 2.0 file whose header names no sensor that is decoded");
    }
    if (header->camera_bits != 0) refuse(path, "holds several cameras");
    const int width = is_dvs128 ? 128 : header->width;
    const int height = is_dvs128 ? 128 : header->height;
    return Opened{
        Aedat2Decoder(Aedat2Config{.chip = header->chip, .width = width, .height = height}),
        header->size, width, height};
  }
  const auto header = read_aedat3_header(front);
  if (!header) return std::nullopt;
  if (!header->raw) refuse(path, "is a compressed AEDAT 3.1 file; only RAW ones have a decoder");
  if (header->sources > 1) refuse(path, "holds several cameras");
  return Opened{Aedat3Decoder({.first_offset = header->size}), header->size, header->width,
                header->height};
}

std::optional<Opened> open_event_stream(const std::filesystem::path& path, Bytes front) {
  const auto header = read_event_stream_header(front);
  if (!header) return std::nullopt;
  if (header->type != EventStreamHeader::Type::dvs) refuse(path, "is an Event Stream without DVS");
  constexpr std::uint16_t kRowsOfAnAtis = 240;
  const int height = header->height > 0 ? header->height : kRowsOfAnAtis;
  return Opened{EventStreamDecoder({.version = header->version, .height = height}), header->size,
                header->width, header->height};
}

// A first line that begins with a letter names the columns.
Opened open_text(Bytes front, TextConfig config) {
  const auto letter = [](std::byte byte) {
    const int lower = std::to_integer<int>(byte) | 0x20;
    return lower >= 'a' && lower <= 'z';
  };
  std::size_t header = 0;
  if (!front.empty() && letter(front.front())) {
    const auto end = std::ranges::find(front, std::byte{'\n'});
    header = static_cast<std::size_t>(end - front.begin()) + (end != front.end() ? 1 : 0);
  }
  config.first_offset = header;
  return {.decoder = TextDecoder(config), .header = header};
}

Opened open(const std::filesystem::path& path, Bytes front, const TextConfig& text) {
  for (const auto& read : {open_raw, open_aedat, open_event_stream}) {
    if (std::optional<Opened> opened = read(path, front)) return *std::move(opened);
  }
  const std::string name = path.extension().string();
  if (name == ".csv" || name == ".txt") return open_text(front, text);
  refuse(path,
         "is none of RAW, DAT, AEDAT 2.0, AEDAT 3.1, Event Stream, .csv and .txt; "
         "asap convert writes other recordings as .csv");
}

}  // namespace

struct RecordingSource::Impl {
  Impl(const std::filesystem::path& its_path, RecordingConfig config);

  Bytes read(std::size_t max);
  void finish();

  const std::filesystem::path path;
  std::ifstream file;
  std::vector<std::byte> bytes;
  std::vector<Event> events;
  std::size_t chunk_bytes;
  Bytes rest;  // of the front, behind the header
  std::optional<recording::Opened> opened;
  std::atomic<bool> cancelled{false};
  bool is_cut = false;
};

RecordingSource::Impl::Impl(const std::filesystem::path& its_path, RecordingConfig config)
    : path(its_path), file(path, std::ios::binary), chunk_bytes(config.chunk_bytes) {
  require(chunk_bytes > 0, "chunk_bytes", chunk_bytes, "must be at least 1");
  if (!file) throw std::system_error(errno, std::generic_category(), path.string());
  const Bytes front = read(kLongestHeader);
  opened = open(path, front, config.text);
  rest = front.subspan(opened->header);
}

// The next bytes; none at the end of the file.
Bytes RecordingSource::Impl::read(std::size_t max) {
  bytes.resize(std::max(bytes.size(), max));
  file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(max));
  if (file.bad()) throw std::system_error(errno, std::generic_category(), path.string());
  return std::span(bytes).first(static_cast<std::size_t>(file.gcount()));
}

void RecordingSource::Impl::finish() {
  is_cut = std::visit(
      [this](auto& decoder) {
        if constexpr (std::is_same_v<decltype(decoder), TextDecoder&>) {
          return !decoder.finish(events);
        } else {
          return decoder.unfinished() > 0;
        }
      },
      opened->decoder);
}

RecordingSource::RecordingSource(const std::filesystem::path& path, RecordingConfig config)
    : impl_(std::make_unique<Impl>(path, std::move(config))) {}

RecordingSource::~RecordingSource() = default;

EventSpan RecordingSource::next() {
  impl_->events.clear();
  while (impl_->events.empty() && !impl_->cancelled.load(std::memory_order_relaxed)) {
    Bytes part = impl_->rest.first(std::min(impl_->rest.size(), impl_->chunk_bytes));
    impl_->rest = impl_->rest.subspan(part.size());
    if (part.empty()) part = impl_->read(impl_->chunk_bytes);
    if (part.empty()) {
      impl_->finish();
      break;
    }
    std::visit([&](auto& decoder) { decoder.decode(part, impl_->events); }, impl_->opened->decoder);
  }
  return impl_->events;
}

void RecordingSource::cancel() noexcept { impl_->cancelled.store(true, std::memory_order_relaxed); }

int RecordingSource::width() const noexcept { return impl_->opened->width; }
int RecordingSource::height() const noexcept { return impl_->opened->height; }

std::uint64_t RecordingSource::bad_records() const noexcept {
  return std::visit([](const auto& decoder) { return decoder.bad_records(); },
                    impl_->opened->decoder);
}

bool RecordingSource::is_cut() const noexcept { return impl_->is_cut; }

}  // namespace asap
