// Encoder: any events in any encoding, with any room. What it takes, the decoder gives back; what
// it refuses is named. The room makes no difference.
#include <algorithm>
#include <stdexcept>
#include <string>
#include <vector>

#include "asap/formats/atis.hpp"
#include "asap/formats/encoder.hpp"
#include "asap/formats/prophesee.hpp"
#include "asap/formats/text.hpp"
#include "bytes.hpp"

using namespace asap;

namespace {

constexpr std::size_t kMostBytes = 1 << 17;  // gaps are worth many

// Whether all events were encoded before there were kMostBytes.
bool encode(Encoder& encoder, std::span<const Event> events, std::size_t room,
            std::vector<std::byte>& bytes) {
  std::vector<std::byte> piece(room);
  while (!events.empty()) {
    if (bytes.size() > kMostBytes) return false;
    const Progress done = encoder.encode(events, piece);
    fuzz::check(done.bytes > 0);
    bytes.insert(bytes.end(), piece.begin(),
                 piece.begin() + static_cast<std::ptrdiff_t>(done.bytes));
    events = events.subspan(done.events);
  }
  return bytes.size() <= kMostBytes;
}

template <class Decoder>
std::vector<Event> decode(Decoder decoder, std::span<const std::byte> bytes) {
  std::vector<Event> events(bytes.size() + Decoder::kMaxPerRecord);
  const Progress done = decoder.decode(bytes, std::span(events));
  fuzz::check(done.bytes == bytes.size() && decoder.unfinished() == 0);
  events.resize(done.events);
  return events;
}

std::vector<Event> decode(const EncoderConfig& config, std::span<const std::byte> bytes) {
  switch (config.encoding) {
    case Encoding::evt3:
      return decode(Evt3Decoder(), bytes);
    case Encoding::event_stream:
      return decode(EventStreamDecoder({.height = config.height}), bytes);
    case Encoding::csv:
      break;
  }
  TextDecoder decoder({.time_exponent = 0});
  std::vector<Event> events;
  decoder.decode(bytes, events);
  return events;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Bytes input(data, size);
  const EncoderConfig config{.encoding = static_cast<Encoding>(input.below(3)),
                             .width = input.take<std::uint16_t>(),
                             .height = input.take<std::uint16_t>()};
  const std::size_t room = Encoder::kMaxPerEvent + input.below(100);
  std::vector<Event> events = input.stream(200);
  try {
    Encoder whole(config), cut(config);
    std::vector<std::byte> bytes, same;
    const bool ended = encode(whole, events, 1 << 14, bytes);
    if (!ended) return 0;
    fuzz::check(encode(cut, events, room, same) && bytes == same);
    for (Event& event : events) event.p = event.p > 0 ? 1 : 0;
    const bool clamped = config.encoding == Encoding::csv;  // by the reader, beyond 2^62 us
    fuzz::check(clamped || decode(config, bytes) == events);
  } catch (const std::invalid_argument& refused) {
    fuzz::check(std::string(refused.what()).find(" = ") != std::string::npos);
  }
  return 0;
}
