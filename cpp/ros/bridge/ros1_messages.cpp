#include "ros/bridge/ros1_messages.hpp"

#include <algorithm>
#include <concepts>

#include "asap/formats/packets.hpp"

namespace asap::ros {
namespace {

#define ASAP_ROS1_HEADER                                                               \
  "================================================================================\n" \
  "MSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n"

constexpr std::int64_t kNsPerS = 1'000'000'000;
constexpr std::int64_t kUsPerS = 1'000'000;
constexpr std::size_t kRecord = 13;       // bytes of an event
constexpr std::size_t kMostNumbers = 64;  // bytes of the other numbers in a message, or less

class Fields {
 public:
  explicit Fields(std::span<const std::byte> bytes) : rest_(bytes) {}

  // 0 where the bytes do not suffice.
  template <std::unsigned_integral T>
  T number() {
    T value = 0;
    const auto of = bytes(sizeof value);
    for (std::size_t i = 0; i < of.size(); ++i) {
      value = static_cast<T>(value | static_cast<T>(std::to_integer<T>(of[i]) << (8 * i)));
    }
    return value;
  }

  std::span<const std::byte> bytes(std::uint64_t count) {
    is_torn_ = is_torn_ || count > rest_.size();
    if (is_torn_) return {};
    const auto taken = rest_.first(static_cast<std::size_t>(count));
    rest_ = rest_.subspan(taken.size());
    return taken;
  }

  std::string_view text() {
    const auto of = bytes(number<std::uint32_t>());
    return {reinterpret_cast<const char*>(of.data()), of.size()};
  }

  // To be asked at the end.
  bool is_torn() const { return is_torn_ || !rest_.empty(); }

 private:
  std::span<const std::byte> rest_;
  bool is_torn_ = false;
};

class Writer {
 public:
  explicit Writer(std::uint8_t* to) : to_(to) {}

  template <std::unsigned_integral T>
  void number(T value) {
    for (std::size_t i = 0; i < sizeof value; ++i) {
      *to_++ = static_cast<std::uint8_t>(value >> (8 * i));
    }
  }
  template <class Bytes>
  void bytes(const Bytes& of) {
    number(static_cast<std::uint32_t>(of.size()));
    to_ = std::copy(of.begin(), of.end(), to_);
  }
  // `count` of which there are `per_s`.
  void time(std::int64_t count, std::int64_t per_s) {
    number(static_cast<std::uint32_t>(count / per_s));
    number(static_cast<std::uint32_t>(count % per_s * (kNsPerS / per_s)));
  }

  const std::uint8_t* end() const { return to_; }

 private:
  std::uint8_t* to_;
};

}  // namespace

const Ros1Type kEventArray{
    "dvs_msgs/EventArray", "5e8beee5a6c107e504c2e78903c224b8",
    "std_msgs/Header header\nuint32 height\nuint32 width\ndvs_msgs/Event[] "
    "events\n" ASAP_ROS1_HEADER
    "================================================================================\n"
    "MSG: dvs_msgs/Event\nuint16 x\nuint16 y\ntime ts\nbool polarity\n"};

const Ros1Type kEventPacket{
    "event_camera_msgs/EventPacket", "8a6101b351a64529ac77bd8b71074e52",
    "std_msgs/Header header\nuint32 height\nuint32 width\nuint64 seq\nuint64 time_base\n"
    "string encoding\nbool is_bigendian\nuint8[] events\n" ASAP_ROS1_HEADER};

Packet read_ros1(std::string_view md5, std::span<const std::byte> bytes,
                 std::vector<Event>& events) {
  Packet packet{.encoding = "another type"};
  const bool is_array = md5 == kEventArray.md5;
  if (!is_array && md5 != kEventPacket.md5) return packet;
  Fields fields(bytes);
  packet.seq = fields.number<std::uint32_t>();
  packet.stamp_ns = fields.number<std::uint32_t>() * kNsPerS;
  packet.stamp_ns += fields.number<std::uint32_t>();
  packet.frame_id = fields.text();
  packet.sensor.height = fields.number<std::uint32_t>();
  packet.sensor.width = fields.number<std::uint32_t>();
  if (is_array) {
    packet.encoding = kDecoded;
    const std::uint64_t count = fields.number<std::uint32_t>();
    const DvsRecords records(fields.bytes(count * kRecord), DvsRecords::Layout::ros1);
    events.resize(records.whole());
    records.decode(0, events);
    packet.events = events;
  } else {
    packet.seq = fields.number<std::uint64_t>();
    packet.time_base = fields.number<std::uint64_t>();
    packet.encoding = fields.text();
    packet.is_bigendian = fields.number<std::uint8_t>() != 0;
    packet.bytes = fields.bytes(fields.number<std::uint32_t>());
  }
  return fields.is_torn() ? Packet{.encoding = "torn", .is_torn = true} : packet;
}

void write_ros1(const Message& message, std::string_view frame_id,
                std::vector<std::uint8_t>& bytes) {
  const bool is_array = message.encoding == kDecoded;
  const std::size_t payload = is_array ? message.events.size() * kRecord : message.bytes.size();
  bytes.resize(kMostNumbers + frame_id.size() + message.encoding.size() + payload);
  Writer writer(bytes.data());
  writer.number(static_cast<std::uint32_t>(message.seq));
  writer.time(message.stamp_ns, kNsPerS);
  writer.bytes(frame_id);
  writer.number(message.sensor.height);
  writer.number(message.sensor.width);
  if (is_array) {
    writer.number(static_cast<std::uint32_t>(message.events.size()));
    for (const Event& event : message.events) {
      writer.number(event.x);
      writer.number(event.y);
      writer.time(event.t, kUsPerS);
      writer.number(static_cast<std::uint8_t>(event.p > 0));
    }
  } else {
    writer.number(message.seq);
    writer.number(message.time_base);
    writer.bytes(message.encoding);
    writer.number(std::uint8_t{0});  // little-endian
    writer.bytes(message.bytes);
  }
  bytes.resize(static_cast<std::size_t>(writer.end() - bytes.data()));
}

}  // namespace asap::ros
