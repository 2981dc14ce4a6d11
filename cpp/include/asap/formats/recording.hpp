// RecordingSource: the events of a recording's file, chunk by chunk. The first bytes tell the
// format; lines of numbers are told by the name: .csv or .txt. The error of another file lists the
// formats.
//
//   RecordingSource recording{"flight.raw"};
//   replay.run(recording, algorithm);      // or simulator.run(recording)
//
// One thread, but for cancel(). Memory: a chunk of bytes, and its events.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "asap/core/event.hpp"
#include "asap/formats/text.hpp"

namespace asap::inline v0_1 {

struct RecordingConfig {
  TextConfig text{};                               // columns and unit of a .csv or .txt file
  std::size_t chunk_bytes = std::size_t{1} << 18;  // of the file, read at once
  std::string format{};                            // "evt3", "atis40"...; empty: as the file says
  int width = 0, height = 0;                       // px, where the file does not say
  std::string stream{};                            // camera, where the file holds several
};

class RecordingSource final : public EventSource {
 public:
  // Opens the file and reads its header. Throws std::system_error where it cannot be read, and
  // std::invalid_argument, with the file's path, where it has no decoder, or where a header names
  // other columns or another unit than config.text.
  explicit RecordingSource(const std::filesystem::path& path, RecordingConfig config = {});
  ~RecordingSource() override;

  // Throws std::system_error where reading fails.
  [[nodiscard]] EventSpan next() override;
  void cancel() noexcept override;

  // Size of the sensor in px; 0 where neither file nor configuration says.
  int width() const noexcept;
  int height() const noexcept;

  // So far: bad records; lines of text with a position beyond 16 bits; records of RAW before the
  // first one that tells the time. None of them is in the ledger of a run.
  std::uint64_t bad_records() const noexcept;
  std::uint64_t out_of_bounds() const noexcept;
  std::uint64_t before_start() const noexcept;
  // At the end: the file ends inside a record, or zeros fill it to its end, which were not read.
  bool is_cut() const noexcept;

 private:
  struct Impl;
  const std::unique_ptr<Impl> impl_;
};

}  // namespace asap::inline v0_1
