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

}  // namespace

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

std::string sentence(Refusal refusal, const Packet& packet, std::string_view publisher) {
  const char* const remedy =
      refusal == Refusal::encoding ? "; evt3, libcaer, libcaer_cmp and mono are read" : "";
  return std::string(kRefusals[static_cast<std::size_t>(refusal)]) + " (from " +
         std::string(publisher) + ", encoding \"" + std::string(packet.encoding) + "\", " +
         std::to_string(packet.sensor.width) + " x " + std::to_string(packet.sensor.height) +
         " px, " + std::to_string(packet.bytes.size()) + " bytes)" + remedy;
}

PacketReader::PacketReader() : block_(kBlockOfEvents) {}

bool PacketReader::is_heard(const Packet& packet) const {
  if (packet.publisher != publisher_) return false;
  if (!publisher_.empty()) return true;
  const bool goes_on =
      packet.seq > seq_ || (packet.seq == 0 && seq_ == 0 && packet.stamp_ns >= stamp_ns_);
  return goes_on && packet.sensor == sensor_ && packet.encoding == encoding_ &&
         packet.frame_id == frame_id_;
}

PacketReader::Seen PacketReader::see(const Packet& packet) {
  const bool goes_on = packet.publisher == publisher_ && packet.encoding == encoding_ &&
                       packet.seq >= seq_ && (packet.seq > 0 || packet.stamp_ns >= stamp_ns_);
  Seen seen{.is_new = !goes_on};
  if (!goes_on) {
    publisher_ = packet.publisher;
    encoding_ = packet.encoding;
    decoder_.emplace<std::monostate>();
    if (encoding_ == "evt3") decoder_.emplace<Evt3Decoder>();
    if (encoding_ == "libcaer") decoder_.emplace<LibcaerDecoder>();
    if (encoding_ == "libcaer_cmp") decoder_.emplace<LibcaerCmpDecoder>();
    if (encoding_ == "mono") decoder_.emplace<MonoDecoder>();
  } else if (const std::uint64_t next = seq_ + 1; packet.seq > next) {
    seen.lost = packet.seq - next - std::min(packet.seq - next, refused_);
    if (auto* const evt3 = std::get_if<Evt3Decoder>(&decoder_)) evt3->resume();
  }
  frame_id_ = packet.frame_id;
  sensor_ = packet.sensor;
  seq_ = packet.seq;
  stamp_ns_ = packet.stamp_ns;
  refused_ = 0;
  return seen;
}

void PacketReader::decode(const Packet& packet, const Sink& sink) {
  decode_all(packet, [&](EventSpan events, std::span<const Trigger>) {
    if (!events.empty()) sink(events);
  });
}

void PacketReader::decode_all(const Packet& packet, const SinkOfAll& sink) {
  std::visit(
      [&](auto& decoder) {
        if constexpr (std::is_same_v<std::remove_cvref_t<decltype(decoder)>, std::monostate>) {
          if (!packet.events.empty()) sink(packet.events, {});
        } else {
          decode_with(decoder, packet, sink);
        }
      },
      decoder_);
}

template <class Known>
void PacketReader::decode_with(Known& decoder, const Packet& packet, const SinkOfAll& sink) {
  const std::uint64_t bad = decoder.bad_records(), unplaced = decoder.before_start();
  const std::uint64_t triggers = decoder.triggers();
  if constexpr (requires { decoder.begin(packet.time_base); }) decoder.begin(packet.time_base);
  for (auto rest = packet.bytes; !rest.empty();) {
    const Progress done = decoder.decode(rest, std::span(block_), std::span(triggers_of_block_));
    rest = rest.subspan(done.bytes);
    if (done.events + done.triggers == 0) continue;
    sink(EventSpan(block_).first(done.events), std::span(triggers_of_block_).first(done.triggers));
  }
  bad_records_ += decoder.bad_records() - bad;
  before_start_ += decoder.before_start() - unplaced;
  triggers_ += decoder.triggers() - triggers;
}

}  // namespace asap::ros
