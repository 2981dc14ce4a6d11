// Messages of ROS 1 as they are on the wire: dvs_msgs/EventArray and event_camera_msgs/EventPacket,
// read and written without their packages, which Debian does not have. The MD5 sum tells the type,
// so the same fields are read under another package's name as well.
//
// One thread. O(bytes).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "asap/core/event.hpp"
#include "ros/bridge/packet_reader.hpp"
#include "ros/bridge/relay.hpp"

namespace asap::ros {

struct Ros1Type {
  const char* name;
  const char* md5;
  const char* definition;  // in full: with the messages that it contains
};
extern const Ros1Type kEventArray;
extern const Ros1Type kEventPacket;

// Reads a message. The packet views its bytes and, for an EventArray, `events`, which are replaced.
// It is torn where the lengths in the message do not fit its bytes; the encoding of a message of
// another type is "another type".
Packet read_ros1(std::string_view md5, std::span<const std::byte> bytes,
                 std::vector<Event>& events);

// Writes an EventArray where the encoding is kDecoded, else an EventPacket. `bytes` are replaced.
void write_ros1(const Message& message, std::string_view frame_id,
                std::vector<std::uint8_t>& bytes);

}  // namespace asap::ros
