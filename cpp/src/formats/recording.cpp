#include "asap/formats/recording.hpp"

#include <algorithm>
#include <atomic>
#include <cctype>
#include <cerrno>
#include <fstream>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <variant>
#include <vector>

#include "core/check.hpp"
#include "formats/opener.hpp"

namespace asap::inline v0_1 {
namespace {

using Bytes = std::span<const std::byte>;

// The columns of a header line. "time [s]" is one name.
std::vector<std::string> names_in(std::string_view line) {
  std::vector<std::string> names;
  for (const char character : line) {
    const auto lower = static_cast<char>(std::tolower(static_cast<unsigned char>(character)));
    const bool separates = std::string_view(",; \t\r").find(lower) != std::string_view::npos;
    if (names.empty() || (separates && !names.back().empty())) names.emplace_back();
    if (lower == '[' && names.back().empty() && names.size() > 1) names.pop_back();
    if (!separates && lower != '"') names.back() += lower;
  }
  if (!names.empty() && names.back().empty()) names.pop_back();
  return names;
}

// The letter of TextConfig::order for a column of this name, '-' for another.
char letter_of(std::string_view name) {
  if (name == "on") return 'p';
  const char first = name.empty() ? '-' : name.front();
  return std::string_view("txyp").find(first) == std::string_view::npos ? '-' : first;
}

// The exponent that the name of a column of times states, as "t_us" and "time[s]" do.
int exponent_of(std::string_view name, int otherwise) {
  const auto end = name.find_last_not_of("])_");
  const auto unit = name.substr(0, end + 1);
  const auto before = unit.find_last_of("[(_");
  if (before == std::string_view::npos) return otherwise;
  const std::string_view stated = unit.substr(before + 1);
  for (const auto& [known, exponent] :
       {std::pair{"s", 6}, std::pair{"ms", 3}, std::pair{"us", 0}, std::pair{"ns", -3}}) {
    if (stated == known) return exponent;
  }
  return otherwise;
}

// Refuses a header that names other columns or another unit than the configuration.
void check_header(const std::filesystem::path& path, const std::string& line,
                  const TextConfig& config) {
  const std::vector<std::string> names = names_in(line);
  const std::string where = "the header of " + path.string() + " says '" + line + "'. ";
  for (std::size_t i = 0; i < std::min(names.size(), config.order.size()); ++i) {
    const char wanted = config.order[i];
    const char found = letter_of(names[i]);
    if (wanted == '-' || found == '-') continue;
    if (wanted != found) {
      std::string order;
      for (const std::string& name : names) order += letter_of(name);
      throw_bad_value("text.order", "'" + config.order + "'", where + "Give '" + order + "'");
    }
    if (wanted != 't') continue;
    const int exponent = exponent_of(names[i], config.time_exponent);
    require(exponent == config.time_exponent, "text.time_exponent", config.time_exponent,
            where + "Give " + std::to_string(exponent));
  }
}

// A first line that begins with a letter names the columns.
std::uint64_t text_start(const std::filesystem::path& path, const TextConfig& config) {
  std::ifstream file(path);
  if (!file) throw std::system_error(errno, std::generic_category(), path.string());
  std::string line;
  std::getline(file, line);
  const int lower = line.empty() ? 0 : line.front() | 0x20;
  if (lower < 'a' || lower > 'z') return 0;
  check_header(path, line.substr(0, line.find('\r')), config);
  return line.size() + (file.eof() ? 0 : 1);
}

bool is_text(const std::filesystem::path& path, const RecordingConfig& config) {
  std::string name = path.extension().string();
  std::ranges::transform(name, name.begin(), [](unsigned char c) { return std::tolower(c); });
  return config.format == "text" || (config.format.empty() && (name == ".csv" || name == ".txt"));
}

// The number of the camera that the user names, in a file of several.
std::size_t stream_of(const std::filesystem::path& path, const OpenedRecording& opened,
                      const std::string& wanted) {
  if (opened.streams.empty() && wanted.empty()) return 0;
  const auto found = std::ranges::find(opened.streams, wanted, &RecordingStream::name);
  if (found != opened.streams.end()) {
    return static_cast<std::size_t>(found - opened.streams.begin());
  }
  if (opened.streams.size() == 1 && wanted.empty()) return 0;
  std::string listed;
  for (const RecordingStream& stream : opened.streams) {
    listed += (listed.empty() ? "" : ", ") + stream.words;
  }
  throw_bad_value("stream", "'" + wanted + "'",
                  path.string() + " (" + std::string(opened.format) +
                      ") holds the cameras: " + (listed.empty() ? "one without a name" : listed));
}

}  // namespace

struct RecordingSource::Impl {
  Impl(const std::filesystem::path& its_path, RecordingConfig config);

  Bytes read();
  void finish();

  // Calls `use` with the decoder.
  template <class Use>
  auto with_decoder(Use use) {
    return words ? std::visit(use, *words) : use(*text);
  }

  const std::filesystem::path path;
  std::ifstream file;
  std::vector<std::byte> bytes;
  std::vector<Event> events;
  std::optional<RecordingDecoder> words;
  std::optional<TextDecoder> text;  // where there are no words
  int width = 0, height = 0;
  std::uint64_t left = 0;  // bytes to be read
  bool has_zeros = false;  // behind them
  std::atomic<bool> cancelled{false};
  bool is_cut = false;
};

RecordingSource::Impl::Impl(const std::filesystem::path& its_path, RecordingConfig config)
    : path(its_path), width(config.width), height(config.height) {
  require(config.chunk_bytes > 0, "chunk_bytes", config.chunk_bytes, "must be at least 1");
  bytes.resize(config.chunk_bytes);
  std::uint64_t start = 0;
  const bool named_text = config.format == "text";
  if (const auto opened = named_text ? std::nullopt : open_recording(path, config)) {
    const std::size_t stream = stream_of(path, *opened, config.stream);
    start = opened->start;
    words = opened->make(start, stream);
    width = opened->streams.empty() ? opened->width : opened->streams[stream].width;
    height = opened->streams.empty() ? opened->height : opened->streams[stream].height;
  } else if (is_text(path, config)) {
    config.text.first_offset = start = text_start(path, config.text);
    text.emplace(config.text);
  } else {
    throw_bad_value("path", path.string(),
                    "is none of " + listed_formats() +
                        ", .csv and .txt; asap convert writes other recordings as .csv");
  }
  file.open(path, std::ios::binary);
  file.seekg(static_cast<std::streamoff>(start));
  const std::uint64_t end = data_end(path);
  has_zeros = end > 0;
  left = std::max(has_zeros ? end : std::filesystem::file_size(path), start) - start;
}

// The next bytes; none at the end of the file.
Bytes RecordingSource::Impl::read() {
  const std::uint64_t size = std::min<std::uint64_t>(bytes.size(), left);
  left -= size;
  file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
  if (file.bad()) throw std::system_error(errno, std::generic_category(), path.string());
  return std::span(bytes).first(static_cast<std::size_t>(file.gcount()));
}

void RecordingSource::Impl::finish() {
  is_cut = has_zeros ? true
           : words   ? std::visit([](auto& decoder) { return decoder.unfinished() > 0; }, *words)
                     : !text->finish(events);
}

RecordingSource::RecordingSource(const std::filesystem::path& path, RecordingConfig config)
    : impl_(std::make_unique<Impl>(path, std::move(config))) {}

RecordingSource::~RecordingSource() = default;

EventSpan RecordingSource::next() {
  impl_->events.clear();
  while (impl_->events.empty() && !impl_->cancelled.load(std::memory_order_relaxed)) {
    const Bytes part = impl_->read();
    if (part.empty()) {
      impl_->finish();
      break;
    }
    impl_->with_decoder([&](auto& decoder) { decoder.decode(part, impl_->events); });
  }
  return impl_->events;
}

void RecordingSource::cancel() noexcept { impl_->cancelled.store(true, std::memory_order_relaxed); }

int RecordingSource::width() const noexcept { return impl_->width; }
int RecordingSource::height() const noexcept { return impl_->height; }

std::uint64_t RecordingSource::bad_records() const noexcept {
  return impl_->with_decoder([](const auto& decoder) { return decoder.bad_records(); });
}

std::uint64_t RecordingSource::out_of_bounds() const noexcept {
  return impl_->text ? impl_->text->out_of_bounds() : 0;
}

std::uint64_t RecordingSource::before_start() const noexcept {
  return impl_->words ? std::visit([](const auto& d) { return d.before_start(); }, *impl_->words)
                      : 0;
}

bool RecordingSource::is_cut() const noexcept { return impl_->is_cut; }

}  // namespace asap::inline v0_1
