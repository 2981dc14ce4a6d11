#include "ros/bridge/packet_reader.hpp"

#include <algorithm>
#include <type_traits>

namespace asap::ros {
namespace {

constexpr std::size_t kBlockOfEvents = 1 << 14;  // events

struct KnownEncoding {
  std::string_view name;
  std::size_t record;  // bytes
};
constexpr std::array<KnownEncoding, 5> kEncodings{
    {{"evt3", 2}, {"libcaer", 8}, {"libcaer_cmp", 2}, {"mono", 8}, {kDecoded, 1}}};

std::optional<Refusal> refusal_of(const Packet& packet) {
  const auto known = std::ranges::find(kEncodings, packet.encoding, &KnownEncoding::name);
  const auto is_side = [](std::uint32_t px) { return px >= 1 && px <= kMostPixels; };
  if (packet.is_torn) return Refusal::size;
  if (known == kEncodings.end()) return Refusal::encoding;
  if (packet.is_bigendian) return Refusal::big_endian;
  if (packet.bytes.size() % known->record != 0) return Refusal::size;
  if (!is_side(packet.sensor.width) || !is_side(packet.sensor.height)) return Refusal::geometry;
  return {};
}

}  // namespace

std::string sentence(Refusal refusal, const Packet& packet) {
  return std::string("message refused: ") + kRefusals[static_cast<std::size_t>(refusal)] +
         " (encoding \"" + std::string(packet.encoding) + "\", " +
         std::to_string(packet.sensor.width) + " x " + std::to_string(packet.sensor.height) +
         " px, " + std::to_string(packet.bytes.size()) + " bytes)";
}

PacketReader::PacketReader() : block_(kBlockOfEvents) { streams_.reserve(kPublishers + 1); }

PacketReader::Stream* PacketReader::find(std::string_view publisher) {
  const auto found = std::ranges::find(streams_, publisher, &Stream::publisher);
  if (found == streams_.end()) return nullptr;
  std::rotate(found, found + 1, streams_.end());
  return &streams_.back();
}

PacketReader::Seen PacketReader::see(const Packet& packet) {
  Seen seen{.refusal = refusal_of(packet)};
  Stream* stream = find(packet.publisher);
  if (stream != nullptr && packet.seq > stream->seq) seen.lost = packet.seq - stream->seq - 1;
  const bool goes_on = stream != nullptr && packet.seq >= stream->seq;
  if (goes_on) stream->seq = packet.seq;  // a message that is refused was not lost
  if (seen.refusal) return seen;

  if (!goes_on || packet.encoding != stream->encoding) {
    seen.is_new = !goes_on;
    if (stream == nullptr) stream = &streams_.emplace_back();
    *stream = {.publisher = std::string(packet.publisher),
               .encoding = std::string(packet.encoding),
               .decoder = {},
               .seq = packet.seq};
    if (packet.encoding == "evt3") stream->decoder.emplace<Evt3Decoder>();
    if (packet.encoding == "libcaer") stream->decoder.emplace<LibcaerDecoder>();
    if (packet.encoding == "libcaer_cmp") stream->decoder.emplace<LibcaerCmpDecoder>();
    if (packet.encoding == "mono") stream->decoder.emplace<MonoDecoder>();
    if (streams_.size() > kPublishers) streams_.erase(streams_.begin());
  } else if (auto* const evt3 = std::get_if<Evt3Decoder>(&stream->decoder); evt3 && seen.lost) {
    evt3->resume();
  }
  return seen;
}

void PacketReader::decode(const Packet& packet, const Sink& sink) {
  std::visit(
      [&](auto& decoder) {
        if constexpr (std::is_same_v<std::remove_cvref_t<decltype(decoder)>, std::monostate>) {
          if (!packet.events.empty()) sink(packet.events);
        } else {
          decode_with(decoder, packet, sink);
        }
      },
      streams_.back().decoder);
}

template <class Known>
void PacketReader::decode_with(Known& decoder, const Packet& packet, const Sink& sink) {
  const std::uint64_t bad = decoder.bad_records(), unplaced = decoder.before_start();
  if constexpr (requires { decoder.begin(packet.time_base); }) decoder.begin(packet.time_base);
  for (auto rest = packet.bytes; !rest.empty();) {
    const Progress done = decoder.decode(rest, std::span(block_));
    rest = rest.subspan(done.bytes);
    if (done.events > 0) sink(EventSpan(block_).first(done.events));
  }
  bad_records_ += decoder.bad_records() - bad;
  before_start_ += decoder.before_start() - unplaced;
}

}  // namespace asap::ros
