// PacketReader: events of messages of event_camera_msgs, of one publisher at a time: EVT3 words run
// on from message to message. A message is read whole or refused whole.
//
// One thread. O(bytes). Allocates only for a publisher that is new.
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
  std::string_view publisher{};  // any bytes that tell publishers apart; none: see is_heard()
  std::string_view frame_id{};
  std::int64_t stamp_ns = 0;
  Geometry sensor{};
  std::uint64_t seq = 0;        // 0 in every message: the publisher does not count
  std::uint64_t time_base = 0;  // ns
  std::string_view encoding{};
  bool is_bigendian = false;
  std::span<const std::byte> bytes{};
  EventSpan events{};          // instead of bytes, where the encoding is kDecoded
  bool is_torn = false;        // the message ends before or behind its own fields
  std::int64_t waited_ns = 0;  // in the middleware, since it was received
};

inline constexpr std::string_view kDecoded = "dvs_msgs";  // the middleware has decoded the events

// Why a message was refused. publisher, geometry: another camera is heard.
enum class Refusal : std::uint8_t { encoding, big_endian, size, geometry, publisher };
inline constexpr std::array kRefusals{"encoding", "big_endian", "size", "geometry", "publisher"};

// Why the message cannot be read, whatever came before it.
std::optional<Refusal> refusal_of(const Packet& packet);

// For a log: the reason, what the message was, and what can be read.
std::string sentence(Refusal refusal, const Packet& packet, std::string_view publisher);

class PacketReader {
 public:
  using Sink = std::function<void(EventSpan)>;
  using SinkOfAll = std::function<void(EventSpan, std::span<const Trigger>)>;

  struct Seen {
    bool is_new = false;  // the decoder begins anew: another publisher, or the same one restarted
    std::uint64_t lost = 0;  // messages that are missing before this one
  };

  PacketReader();

  // Whether the message is of the publisher that is heard. One without a name has the same sensor,
  // frame and encoding, and its number or stamp does not go back.
  bool is_heard(const Packet& packet) const;

  // Once per message that is not refused, in the order of arrival. A `seq` or, without one, a stamp
  // that goes back means that the publisher began anew.
  Seen see(const Packet& packet);

  // The message was refused, so it was not lost.
  void refuse(const Packet& packet) noexcept { refused_ += is_heard(packet); }

  // The events of the message that see() has just seen, block by block.
  void decode(const Packet& packet, const Sink& sink);

  // The same with the external triggers of each block, which may have no event.
  void decode_all(const Packet& packet, const SinkOfAll& sink);

  const std::string& publisher() const noexcept { return publisher_; }
  const std::string& frame_id() const noexcept { return frame_id_; }
  std::uint64_t bad_records() const noexcept { return bad_records_; }
  // Events whose time or row is not known, at the start of an EVT3 stream or behind a gap.
  std::uint64_t before_start() const noexcept { return before_start_; }
  // External triggers.
  std::uint64_t triggers() const noexcept { return triggers_; }

 private:
  using Decoder =
      std::variant<std::monostate, Evt3Decoder, LibcaerDecoder, LibcaerCmpDecoder, MonoDecoder>;

  template <class Known>
  void decode_with(Known& decoder, const Packet& packet, const SinkOfAll& sink);

  std::string publisher_;
  std::string frame_id_;
  std::string encoding_;
  Geometry sensor_;
  Decoder decoder_;
  std::uint64_t seq_ = 0;
  std::int64_t stamp_ns_ = 0;
  std::uint64_t refused_ = 0;  // since the last one that was seen
  std::vector<Event> block_;
  std::array<Trigger, 64> triggers_of_block_;
  std::uint64_t bad_records_ = 0;
  std::uint64_t before_start_ = 0;
  std::uint64_t triggers_ = 0;
};

}  // namespace asap::ros
