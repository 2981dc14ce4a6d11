#include "asap/formats/recording.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "asap/formats/encoder.hpp"
#include "formats/decoding.hpp"
#include "support/errors.hpp"

namespace asap::recording_test {
namespace {

using decoding::Bytes;
using decoding::Events;

// A file that goes with the test.
struct File {
  explicit File(const std::string& name, const Bytes& bytes)
      : path(std::filesystem::path(testing::TempDir()) / ("asap_recording_" + name)) {
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
  }
  ~File() { std::filesystem::remove(path); }
  File(const File&) = delete;
  File& operator=(const File&) = delete;

  const std::filesystem::path path;
};

Events some_events() {
  Events events;
  for (std::int64_t i = 0; i < 3000; ++i) {
    const auto place = static_cast<std::uint16_t>(i % 200);
    events.push_back({.x = place, .y = place, .p = static_cast<std::int16_t>(i % 2), .t = 40 * i});
  }
  return events;
}

Bytes encoded(Encoding encoding) {
  Encoder encoder({.encoding = encoding, .width = 346, .height = 260});
  Bytes bytes;
  decoding::append(bytes, encoder.header());
  const Events events = some_events();
  Bytes body(events.size() * Encoder::kMaxPerEvent);
  const Progress progress = encoder.encode(events, body);
  EXPECT_EQ(progress.events, events.size());
  bytes.insert(bytes.end(), body.begin(),
               body.begin() + static_cast<std::ptrdiff_t>(progress.bytes));
  return bytes;
}

Events read_all(RecordingSource& recording) {
  Events events;
  for (EventSpan chunk = recording.next(); !chunk.empty(); chunk = recording.next()) {
    events.insert(events.end(), chunk.begin(), chunk.end());
  }
  return events;
}

TEST(RecordingSource, PicksTheDecoderByTheFile) {
  const RecordingConfig in_pieces{.text = {.time_exponent = 0}, .chunk_bytes = 1001};
  const auto names = {"evt3.raw", "events.es", "events.csv"};
  auto encoding = Encoding::evt3;
  for (const char* const name : names) {
    SCOPED_TRACE(name);
    const File file(name, encoded(encoding));
    RecordingSource recording(file.path, in_pieces);
    EXPECT_EQ(read_all(recording), some_events());
    EXPECT_EQ(recording.bad_records(), 0u);
    EXPECT_FALSE(recording.is_cut());
    if (encoding != Encoding::csv) {
      EXPECT_EQ(recording.width(), 346);
      EXPECT_EQ(recording.height(), 260);
    }
    encoding = static_cast<Encoding>(static_cast<int>(encoding) + 1);
  }
}

// Packets of one event, at this time, from each of the cameras.
Bytes aedat3_of(const std::vector<std::pair<unsigned, std::uint64_t>>& cameras_and_times) {
  Bytes bytes;
  decoding::append(bytes,
                   "#!AER-DAT3.1\r\n#Format: RAW\r\n#Source 1: DAVIS346\r\n"
                   "#!END-HEADER\r\n");
  for (const auto& [camera, time] : cameras_and_times) {
    for (const std::uint64_t field : {camera << 16 | 1u, 8u, 4u, 0u, 1u, 1u, 1u}) {
      decoding::append_little(bytes, field, 4);
    }
    decoding::append_little(bytes, time << 32 | 7, 8);
  }
  return bytes;
}

TEST(RecordingSource, ReadsAedat) {
  Bytes dvs128;
  decoding::append(dvs128, "#!AER-DAT2.0\r\n# AEChip: eu.seebetter.DVS128\r\n");
  decoding::append_big(dvs128, 5 << 8 | 3 << 1, 4);
  decoding::append_big(dvs128, 77, 4);
  const File second("dvs128.aedat", dvs128);
  RecordingSource from_jaer(second.path);
  EXPECT_EQ(read_all(from_jaer).at(0).t, 77);

  const File third("davis.aedat", aedat3_of({{1, 88}}));
  RecordingSource from_caer(third.path);
  EXPECT_EQ(read_all(from_caer).at(0).t, 88);
}

// Whatever a Python user is refused, a C++ user is: header, bytes behind it, words of the refusal.
TEST(RecordingSource, RefusesWhatHasNoDecoderByFileAndFault) {
  const std::string dat = "% Data file containing events.\n% Version ";
  const struct {
    std::string front;
    std::string words;
  } refused[] = {
      {"#!AER-DAT2.0\r\n# HardwareInterface: DAVIS FX2\r\n", "AEDAT 2.0"},
      {"#!AER-DAT3.1\r\n#Format: SerializedTS\r\n#!END-HEADER\r\n", "compressed AEDAT 3.1"},
      {dat + "2\n\x0e\x08", "DAT with events of type 14"},
      {dat + "5\n\x0c\x08", "DAT of version 5"},
      {std::string("Event Stream\1\0\0", 15), "height"},
      {std::string("Event Stream\2\0\0\2\1\0\1\0", 20), "type atis"},
  };
  for (const auto& [front, words] : refused) {
    Bytes bytes;
    decoding::append(bytes, front);
    decoding::append_big(bytes, std::uint64_t{5} << 22, 8);
    const File file("refused", bytes);
    const std::string error = test::error_of([&] { RecordingSource{file.path}; });
    EXPECT_EQ(error.rfind("path = " + file.path.string(), 0), 0u) << error;
    EXPECT_NE(error.find(words), error.npos) << error;
  }
}

TEST(RecordingSource, ReadsOneOfSeveralCamerasByItsName) {
  const File file("cameras.aedat", aedat3_of({{1, 100}, {2, 40}, {1, 120}}));
  EXPECT_NE(test::error_of([&] { RecordingSource{file.path}; }).find("1 (DAVIS346), 2 (not named)"),
            std::string::npos);
  RecordingConfig config;
  config.stream = "2";
  RecordingSource second(file.path, config);
  EXPECT_EQ(second.width(), 0);
  EXPECT_EQ(read_all(second).at(0).t, 40);
  config.stream = "1";
  RecordingSource first(file.path, config);
  EXPECT_EQ(first.width(), 346);
  EXPECT_EQ(read_all(first).size(), 2u);
}

TEST(RecordingSource, TakesWhatTheFileDoesNotSay) {
  Bytes bytes;
  decoding::append(bytes, std::string("Event Stream\1\0\0", 15));
  decoding::append_little(bytes, 1, 3);  // x 0, lowest row
  const File file("rows.es", bytes);
  RecordingConfig config;
  config.height = 128;
  RecordingSource recording(file.path, config);
  EXPECT_EQ(read_all(recording).at(0).y, 127);
  EXPECT_EQ(recording.height(), 128);
  const File words("words.raw", Bytes(100));
  config.format = "evt3";
  EXPECT_NO_THROW((RecordingSource{words.path, config}));
}

TEST(RecordingSource, RefusesAHeaderThatNamesOtherColumnsOrAnotherUnit) {
  const struct {
    const char* header;
    const char* order;
    int time_exponent;
    const char* fault;
  } headers[] = {
      {"t,x,y,p", "txyp", 0, "nothing was thrown"},
      {"Time [us]; X; Y; Polarity\r", "txyp", 0, "nothing was thrown"},
      {"timestamp_us x y on", "txyp", 0, "nothing was thrown"},
      {"t(s),x,y,p", "txyp", 6, "nothing was thrown"},
      {"track_id,t_us,x,y", "-txy", 0, "nothing was thrown"},
      {"x,y,p,t", "txyp", 0, "text.order = 'txyp': the header"},
      {"t_us,y,x,p", "txyp", 0, "text.order = 'txyp': the header"},
      {"t_us,x,y,p", "txyp", 6, "text.time_exponent = 6: the header"},
      {"time [ns],x,y,p", "txyp", 0, "text.time_exponent = 0: the header"},
  };
  for (const auto& [header, order, time_exponent, fault] : headers) {
    SCOPED_TRACE(header);
    Bytes bytes;
    decoding::append(bytes, header + std::string("\n1,2,3,1\n5,80000,80000,80000\n"));
    const File file("named.CSV", bytes);
    RecordingConfig config;
    config.text.order = order;
    config.text.time_exponent = time_exponent;
    const std::string error = test::error_of([&] {
      RecordingSource recording(file.path, config);
      EXPECT_EQ(read_all(recording).size(), 1u);
      EXPECT_EQ(recording.out_of_bounds(), 1u);
    });
    EXPECT_EQ(error.find(fault), 0u) << error;
  }
}

TEST(RecordingSource, SaysThatTheFileIsCut) {
  Bytes bytes = encoded(Encoding::evt3);
  bytes.pop_back();
  const File file("cut.raw", bytes);
  RecordingSource recording(file.path);
  const Events events = read_all(recording);
  EXPECT_TRUE(std::equal(events.begin(), events.end(), some_events().begin()));
  EXPECT_TRUE(recording.is_cut());
}

TEST(RecordingSource, MakesNoEventsOfZerosThatFillTheFile) {
  for (const Encoding encoding : {Encoding::evt3, Encoding::csv}) {
    Bytes bytes = encoded(encoding);
    bytes.insert(bytes.end(), 2'000'000, std::byte{0});
    const File file(encoding == Encoding::csv ? "zeros.csv" : "zeros.raw", bytes);
    RecordingSource recording(file.path, {.text = {.time_exponent = 0}});
    EXPECT_EQ(read_all(recording), some_events());
    EXPECT_TRUE(recording.is_cut());
    EXPECT_EQ(recording.bad_records(), 0u);
  }
}

TEST(RecordingSource, EndsWhenItIsCancelled) {
  const File file("cancelled.raw", encoded(Encoding::evt3));
  RecordingSource recording(file.path, {.chunk_bytes = 100});
  EXPECT_FALSE(recording.next().empty());
  recording.cancel();
  EXPECT_TRUE(recording.next().empty());
}

TEST(RecordingSource, RefusesWhatItCannotRead) {
  EXPECT_THROW(RecordingSource("no/such/file.raw"), std::system_error);
  const File file("unknown.bin", Bytes(100));
  EXPECT_EQ(test::error_of([&] { RecordingSource{file.path}; }).rfind("path = ", 0), 0u);
}

}  // namespace
}  // namespace asap::recording_test
