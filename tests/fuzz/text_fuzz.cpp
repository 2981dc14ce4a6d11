// TextDecoder: any bytes under any configuration. Every line is an event, empty, or counted; how
// the bytes are cut makes no difference.
#include <algorithm>
#include <stdexcept>
#include <string>
#include <vector>

#include "asap/formats/text.hpp"
#include "bytes.hpp"

using namespace asap;

namespace {

TextConfig config_of(fuzz::Bytes& bytes) {
  static constexpr std::array kOrders{"txyp", "xytp", "yxt", "-t--xyp-", "t-x-y", "pyxt"};
  TextConfig config{.order = kOrders[bytes.below(kOrders.size())]};
  if (bytes.below(16) == 0) {
    config.order.clear();
    for (std::size_t i = bytes.below(20); i > 0; --i) config.order += "txyp-q"[bytes.below(6)];
  }
  config.time_exponent = static_cast<int>(bytes.below(24)) - 12;
  config.clamp = bytes.flag();
  return config;
}

std::uint64_t lines_with_data(std::string_view text) {
  std::uint64_t lines = 0;
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    // The decoder sees no further than its longest line.
    const auto first = line.substr(0, TextDecoder::kMaxLine + 1).find_first_not_of(" ,\t;\r");
    const bool is_blank = first == std::string_view::npos;
    const bool is_long = line.size() > TextDecoder::kMaxLine;
    lines += is_blank ? is_long : line[first] != '#' && line[first] != '%';
  }
  return lines;
}

bool same_books(const TextDecoder& a, const TextDecoder& b) {
  return a.bad_records() == b.bad_records() && a.out_of_bounds() == b.out_of_bounds() &&
         a.clamped_positions() == b.clamped_positions() && std::ranges::equal(a.noted(), b.noted());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Bytes bytes(data, size);
  const TextConfig config = config_of(bytes);
  const std::size_t piece = 1 + bytes.below(64);
  const auto rest = bytes.rest();
  const std::string text(rest.begin(), rest.end());
  try {
    TextDecoder whole(config), cut(config);
    std::vector<Event> events, same;
    whole.decode(std::as_bytes(std::span(text)), events);
    const bool ended_well = whole.finish(events);
    for (std::size_t at = 0; at < text.size(); at += piece) {
      cut.decode(std::as_bytes(std::span(std::string_view(text).substr(at, piece))), same);
    }
    fuzz::check(cut.finish(same) == ended_well);
    fuzz::check(events == same && same_books(whole, cut));
    fuzz::check(lines_with_data(text) ==
                events.size() + whole.bad_records() + whole.out_of_bounds());
    fuzz::check(std::ranges::all_of(whole.noted(), [&](auto at) { return at <= text.size(); }));
  } catch (const std::invalid_argument& refused) {
    fuzz::check(std::string(refused.what()).find(" = ") != std::string::npos);
  }
  return 0;
}
