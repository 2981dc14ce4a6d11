#include "asap/formats/prophesee.hpp"

#include <algorithm>
#include <charconv>
#include <string_view>
#include <type_traits>

#include "formats/opener.hpp"
#include "formats/words.hpp"

namespace asap::inline v0_1 {

namespace {

using Text = std::string_view;

constexpr std::size_t kLongestHeaderLine = 4096;

// The next line without its newline; empty where no header line stands.
Text header_line(Text rest) noexcept {
  if (!rest.starts_with("% ") && !rest.starts_with("%\n")) return {};
  const Text line = rest.substr(0, rest.substr(0, kLongestHeaderLine).find('\n'));
  const bool is_text = std::ranges::all_of(line, [](char c) {
    return (static_cast<unsigned char>(c) >= ' ' && c != '\x7f') || c == '\t' || c == '\r';
  });
  return line.size() < rest.size() && is_text ? line : Text{};
}

Text trimmed(Text text) noexcept {
  const auto is_blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

// The text before `mark`, which is cut off from `rest` with the mark.
Text cut_before(Text& rest, char mark) noexcept {
  const Text part = rest.substr(0, rest.find(mark));
  rest.remove_prefix(std::min(part.size() + 1, rest.size()));
  return trimmed(part);
}

int whole_or(int otherwise, Text text) noexcept {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size() ? value : otherwise;
}

void read_side(Text text, int& side) noexcept {
  const int value = whole_or(0, text);
  if (value > 0 && value <= 65535) side = value;
}

void read_words(Text name, RawHeader& header) noexcept {
  using enum RawHeader::Words;
  if (name == "EVT2" || name == "2.0") header.words = evt2;
  if (name == "EVT21" || name == "EVT2.1" || name == "2.1") header.words = evt21;
  if (name == "EVT3" || name == "3.0") header.words = evt3;
}

void read_format(Text value, RawHeader& header) noexcept {
  header.words = RawHeader::Words::unknown;
  read_words(cut_before(value, ';'), header);
  while (!value.empty()) {
    Text setting = cut_before(value, ';');
    const Text key = cut_before(setting, '=');
    if (key == "width") read_side(trimmed(setting), header.width);
    if (key == "height") read_side(trimmed(setting), header.height);
    if (key == "endianness") header.little_endian = trimmed(setting) == "little";
  }
}

struct Side {
  int width, height;
};

// The sensor of a recording that states no geometry.
Side size_of_sensor(Text plugin) noexcept {
  const auto names = [&](Text part) { return plugin.find(part) != Text::npos; };
  if (names("genx320")) return {320, 320};
  if (names("gen4") || names("imx636")) return {1280, 720};
  if (names("gen3")) return {640, 480};
  return {0, 0};
}

}  // namespace

std::optional<RawHeader> read_raw_header(std::span<const std::byte> bytes) noexcept {
  const Text all(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  RawHeader header;
  Side sensor{0, 0};
  bool has_format = false;
  for (Text line; !(line = header_line(all.substr(header.size))).empty();) {
    header.size += line.size() + 1;
    Text value = trimmed(line.substr(1));
    const Text whole = value;
    const Text key = cut_before(value, ' ');
    value = trimmed(value);
    if (key == "end") break;
    if (key == "evt" && !has_format) read_words(value, header);
    if (key == "format") {
      has_format = true;
      read_format(value, header);
    }
    if (key == "geometry") {
      const Text width = cut_before(value, 'x');
      read_side(width, header.width);
      read_side(trimmed(value), header.height);
    }
    if (key == "endianness") header.little_endian = value == "little";
    if (key == "plugin_name") sensor = size_of_sensor(value);
    if (key == "Version") header.version = whole_or(-1, value);
    if (key == "Width") read_side(value, header.width);
    if (key == "Height") read_side(value, header.height);
    header.is_dat |= whole.starts_with("Data file containing");
  }
  if (header.size == 0) return std::nullopt;
  if (header.width == 0 || header.height == 0) {
    header.width = sensor.width;
    header.height = sensor.height;
  }
  return header;
}

// ---- evt2, evt21, evt3: words after a header, or without one where the user names them ----------

namespace {

bool begins_with(RawHeader::Words words, std::span<const std::byte> front) noexcept {
  const auto header = read_raw_header(front);
  return header && header->words == words;
}

template <class Decoder>
OpenedRecording open_words(const RecordingFile& file, RawHeader::Words words) {
  const RawHeader header = read_raw_header(file.front).value_or(RawHeader{});
  if (header.words != RawHeader::Words::unknown && header.words != words) {
    file.corrupt("the header names another encoding than " + std::string(Decoder::kFormat));
  }
  return {.start = header.size,
          .width = header.width,
          .height = header.height,
          .event_bytes = words == RawHeader::Words::evt21 ? 8u : 4u,
          .make = [=](std::uint64_t at, std::size_t) -> RecordingDecoder {
            if constexpr (std::is_same_v<Decoder, Evt21Decoder>) {
              return Evt21Decoder({.little_endian = header.little_endian, .first_offset = at});
            } else {
              return Decoder({.first_offset = at});
            }
          }};
}

// The first TIME_HIGH among words of kSize times 32 bits, whose upper one is the kUpper-th.
template <std::size_t kSize, std::size_t kUpper>
std::optional<Entry> first_time_high(std::span<const std::byte> piece) {
  constexpr std::size_t kWord = 4 * kSize;
  for (std::size_t at = 0; at + kWord <= piece.size(); at += kWord) {
    const auto word = load_little<std::uint32_t>(piece.data() + at + 4 * kUpper);
    if (word >> 28 == 8) return Entry{at, std::int64_t{word & 0xfff'ffff} << 6};
  }
  return std::nullopt;
}

}  // namespace

bool Evt2Decoder::begins(std::span<const std::byte> front) noexcept {
  return begins_with(RawHeader::Words::evt2, front);
}

OpenedRecording Evt2Decoder::open(const RecordingFile& file) {
  OpenedRecording opened = open_words<Evt2Decoder>(file, RawHeader::Words::evt2);
  opened.entry = &first_time_high<1, 0>;
  return opened;
}

bool Evt21Decoder::begins(std::span<const std::byte> front) noexcept {
  return begins_with(RawHeader::Words::evt21, front);
}

OpenedRecording Evt21Decoder::open(const RecordingFile& file) {
  OpenedRecording opened = open_words<Evt21Decoder>(file, RawHeader::Words::evt21);
  const auto header = read_raw_header(file.front);
  opened.entry = header && header->little_endian ? &first_time_high<2, 1> : &first_time_high<2, 0>;
  return opened;
}

bool Evt3Decoder::begins(std::span<const std::byte> front) noexcept {
  return begins_with(RawHeader::Words::evt3, front);
}

OpenedRecording Evt3Decoder::open(const RecordingFile& file) {
  return open_words<Evt3Decoder>(file, RawHeader::Words::evt3);
}

}  // namespace asap::inline v0_1
