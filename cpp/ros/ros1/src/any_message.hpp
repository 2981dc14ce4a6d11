// AnyMessage: a message of ROS 1 of any type, as bytes; for roscpp, C++17.
#pragma once

#include <ros/message_traits.h>
#include <ros/serialization.h>

#include <algorithm>
#include <cstdint>
#include <vector>

namespace asap_ros {

struct AnyMessage {
  std::vector<std::uint8_t> bytes;
};

}  // namespace asap_ros

namespace ros {
namespace message_traits {

template <>
struct IsMessage<asap_ros::AnyMessage> : TrueType {};

struct AnyType {
  static const char* value() { return "*"; }
  static const char* value(const asap_ros::AnyMessage&) { return "*"; }
};
template <>
struct MD5Sum<asap_ros::AnyMessage> : AnyType {};
template <>
struct DataType<asap_ros::AnyMessage> : AnyType {};
template <>
struct Definition<asap_ros::AnyMessage> : AnyType {};

}  // namespace message_traits

namespace serialization {

template <>
struct Serializer<asap_ros::AnyMessage> {
  template <class Stream>
  static void write(Stream& stream, const asap_ros::AnyMessage& message) {
    const auto size = static_cast<std::uint32_t>(message.bytes.size());
    std::copy(message.bytes.begin(), message.bytes.end(), stream.advance(size));
  }
  template <class Stream>
  static void read(Stream& stream, asap_ros::AnyMessage& message) {
    message.bytes.assign(stream.getData(), stream.getData() + stream.getLength());
  }
  static std::uint32_t serializedLength(const asap_ros::AnyMessage& message) {
    return static_cast<std::uint32_t>(message.bytes.size());
  }
};

}  // namespace serialization
}  // namespace ros
