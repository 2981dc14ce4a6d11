// open_recording: the one place where a file's header is interpreted, for C++ and Python: the
// decoder that its records take, where they begin, the sensor, the cameras.
//
// A decoder is listed once, in RecordingDecoder, and says three things of its format: kFormat, its
// name; begins(front), whether a file begins as one; open(file), what the header says.
// One thread. Reads the header; of AEDAT with several cameras the whole file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "asap/formats/aedat.hpp"
#include "asap/formats/atis.hpp"
#include "asap/formats/prophesee.hpp"
#include "asap/formats/recording.hpp"

namespace asap::inline v0_1 {

// The formats of words. A new decoder is added here.
using RecordingDecoder =
    std::variant<Evt2Decoder, Evt21Decoder, Evt3Decoder, DatDecoder, EventStreamDecoder,
                 Atis40Decoder, Aedat2Decoder, Aedat3Decoder>;

// A file that is no recording, or none that is decoded. what(): "path = <path>: <fault>".
struct BadRecording : std::invalid_argument {
  enum class Kind : std::uint8_t { unsupported, corrupt };

  BadRecording(const std::filesystem::path& path, Kind its_kind, std::uint64_t its_offset,
               const std::string& its_fault);

  Kind kind;
  std::uint64_t offset;  // byte of the file where it shows
  std::string fault;
};

// A file whose header is read, and what the user says of it.
struct RecordingFile {
  const std::filesystem::path& path;
  const RecordingConfig& config;
  std::uint64_t size;                // bytes
  std::span<const std::byte> front;  // the first MiB

  // Both throw BadRecording.
  [[noreturn]] void unsupported(const std::string& fault) const;
  [[noreturn]] void corrupt(const std::string& fault) const;
};

// One of several cameras in a file.
struct RecordingStream {
  std::string name;
  std::string words;  // name and what the header calls it
  int width, height;  // px; 0 where the file does not say
};

// A byte where decoding may begin, and the time there in us.
using Entry = std::pair<std::size_t, std::int64_t>;

struct OpenedRecording {
  std::uint64_t start = 0;      // byte of the first record
  int width = 0, height = 0;    // px; 0 where neither file nor user says
  std::size_t event_bytes = 8;  // about
  std::string_view format{};
  std::string doubt{};                     // as what it is read, and why it may be something else
  std::vector<RecordingStream> streams{};  // empty where it holds one camera
  // Makes the decoder of a stream, for bytes that begin at this offset.
  std::function<RecordingDecoder(std::uint64_t first_offset, std::size_t stream)> make{};
  // The first entry in bytes from the middle of the file; null where the format has none.
  std::optional<Entry> (*entry)(std::span<const std::byte> piece) = nullptr;
};

// Names of the formats.
std::vector<std::string_view> recording_formats();

// The same as words of an error: "evt2, evt21".
std::string listed_formats();

// The format that a file begins as; empty where it is none of these.
std::string_view recording_format(std::span<const std::byte> front);

// The byte where zeros begin that fill the file to its end, 4 kB at least; 0 where there are none.
// A download or a recorder allocates a file first, and a power cut keeps the rest from being
// written. A record that ends with zeros counts to them, because it may be torn.
std::uint64_t data_end(const std::filesystem::path& path);

// Opens a file of config.format, or of the format that it begins as; nothing where that is none.
// Throws BadRecording; std::system_error where the file cannot be read.
std::optional<OpenedRecording> open_recording(const std::filesystem::path& path,
                                              const RecordingConfig& config);

}  // namespace asap::inline v0_1
