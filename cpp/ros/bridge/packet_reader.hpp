// PacketReader: events of messages of event_camera_msgs. Every publisher has a decoder of its own,
// because EVT3 words run on from message to message. A message is read whole or refused whole.
//
// One thread. O(bytes). Allocates only for a publisher that is new; remembers the last kPublishers.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "asap/core/event.hpp"
#include "asap/formats/packets.hpp"
#include "asap/formats/prophesee.hpp"

namespace asap::ros {

struct Geometry {
  std::uint32_t width = 0;  // px
  std::uint32_t height = 0;

  friend bool operator==(const Geometry&, const Geometry&) = default;
};

inline constexpr std::uint32_t kMostPixels = 2048;  // of a side: what EVT3 addresses

// The fields of a message, where they stand.
struct Packet {
  std::string_view publisher{};  // any bytes that tell publishers apart
  Geometry sensor{};
  std::uint64_t seq = 0;        // 0 in every message: the publisher does not count
  std::uint64_t time_base = 0;  // ns
  std::string_view encoding{};
  bool is_bigendian = false;
  std::span<const std::byte> bytes{};
  EventSpan events{};    // instead of bytes, where the encoding is kDecoded
  bool is_torn = false;  // the message ends before or behind its own fields
};

inline constexpr std::string_view kDecoded = "dvs_msgs";  // the middleware has decoded the events

// Why a message was refused.
enum class Refusal : std::uint8_t { encoding, big_endian, size, geometry };
inline constexpr std::array kRefusals{"encoding", "big_endian", "size", "geometry"};

// For a log: the reason, and what the message was.
std::string sentence(Refusal refusal, const Packet& packet);

class PacketReader {
 public:
  using Sink = std::function<void(EventSpan)>;
  static constexpr std::size_t kPublishers = 8;

  struct Seen {
    std::optional<Refusal> refusal;
    bool is_new = false;     // the first message of a publisher, or the first since it began anew
    std::uint64_t lost = 0;  // messages that are missing before this one
  };

  PacketReader();

  // Once per message, in the order of arrival. A `seq` that goes back means that the publisher
  // began anew.
  Seen see(const Packet& packet);

  // The events of the message that see() has just accepted, block by block.
  void decode(const Packet& packet, const Sink& sink);

  std::uint64_t bad_records() const noexcept { return bad_records_; }
  // Events whose time or row is not known, at the start of an EVT3 stream or behind a gap.
  std::uint64_t before_start() const noexcept { return before_start_; }

 private:
  using Decoder =
      std::variant<std::monostate, Evt3Decoder, LibcaerDecoder, LibcaerCmpDecoder, MonoDecoder>;

  struct Stream {
    std::string publisher;
    std::string encoding;
    Decoder decoder;
    std::uint64_t seq = 0;
  };

  Stream* find(std::string_view publisher);
  template <class Known>
  void decode_with(Known& decoder, const Packet& packet, const Sink& sink);

  std::vector<Stream> streams_;  // the one of the last message comes last
  std::vector<Event> block_;
  std::uint64_t bad_records_ = 0;
  std::uint64_t before_start_ = 0;
};

}  // namespace asap::ros
