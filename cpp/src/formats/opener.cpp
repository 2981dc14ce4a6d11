#include "formats/opener.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <fstream>
#include <system_error>
#include <type_traits>

#include "core/check.hpp"

namespace asap::inline v0_1 {

namespace {

using Bytes = std::span<const std::byte>;

constexpr std::size_t kFront = std::size_t{1} << 20;  // bytes; jAER's headers have 170 kB

struct Format {
  std::string_view name;
  bool (*begins)(Bytes) noexcept;
  OpenedRecording (*open)(const RecordingFile&);
};

template <class... Decoders>
constexpr std::array<Format, sizeof...(Decoders)> formats_of(
    std::type_identity<std::variant<Decoders...>>) {
  return {Format{Decoders::kFormat, &Decoders::begins, &Decoders::open}...};
}

constexpr auto kFormats = formats_of(std::type_identity<RecordingDecoder>{});

}  // namespace

BadRecording::BadRecording(const std::filesystem::path& path, Kind its_kind,
                           std::uint64_t its_offset, const std::string& its_fault)
    : std::invalid_argument("path = " + path.string() + ": " + its_fault),
      kind(its_kind),
      offset(its_offset),
      fault(its_fault) {}

void RecordingFile::unsupported(const std::string& fault) const {
  throw BadRecording(path, BadRecording::Kind::unsupported, 0, fault);
}

void RecordingFile::corrupt(const std::string& fault) const {
  throw BadRecording(path, BadRecording::Kind::corrupt, 0, fault);
}

std::vector<std::string_view> recording_formats() {
  std::vector<std::string_view> names;
  for (const Format& format : kFormats) names.push_back(format.name);
  return names;
}

std::string listed_formats() {
  std::string names;
  for (const Format& known : kFormats) names.append(names.empty() ? "" : ", ").append(known.name);
  return names;
}

std::string_view recording_format(Bytes front) {
  const auto* const found =
      std::ranges::find_if(kFormats, [&](const Format& format) { return format.begins(front); });
  return found == kFormats.end() ? std::string_view{} : found->name;
}

std::optional<OpenedRecording> open_recording(const std::filesystem::path& path,
                                              const RecordingConfig& config) {
  std::ifstream file(path, std::ios::binary);
  std::vector<std::byte> bytes(kFront);
  file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!file && !file.eof()) throw std::system_error(errno, std::generic_category(), path.string());
  const Bytes front = std::span(bytes).first(static_cast<std::size_t>(file.gcount()));
  const std::string_view name = config.format.empty() ? recording_format(front) : config.format;
  if (name.empty()) return std::nullopt;
  const auto* const format = std::ranges::find(kFormats, name, &Format::name);
  if (format == kFormats.end()) {
    throw_bad_value("format", config.format, "give one of " + listed_formats());
  }
  OpenedRecording recording = format->open(
      {.path = path, .config = config, .size = std::filesystem::file_size(path), .front = front});
  recording.format = format->name;
  return recording;
}

std::uint64_t data_end(const std::filesystem::path& path) {
  constexpr std::uint64_t kBlock = std::uint64_t{1} << 20, kZeros = 4096;  // bytes
  const std::uint64_t size = std::filesystem::file_size(path);
  std::ifstream file(path, std::ios::binary);
  std::vector<char> block(kBlock);
  std::uint64_t end = size;
  while (end > 0) {
    const std::uint64_t start = end - std::min(end, kBlock);
    file.seekg(static_cast<std::streamoff>(start));
    if (!file.read(block.data(), static_cast<std::streamsize>(end - start))) return 0;
    for (; end > start; --end) {
      if (block[end - start - 1] != 0) return size - end >= kZeros ? end : 0;
    }
  }
  return 0;
}

}  // namespace asap::inline v0_1
