// Messages of the Source, and how old their events are when they arrive: the events of row i have
// the stamp kRows - 1 - i us before the message left.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <event_camera_msgs/msg/event_packet.hpp>
#include <memory>
#include <span>

#include "ros/bridge/packet_reader.hpp"

namespace asap_peers {

namespace ros = asap::ros;
using EventPacket = event_camera_msgs::msg::EventPacket;

inline constexpr std::size_t kRows = 8;
inline constexpr std::int64_t kEvt3Range_us = std::int64_t{1} << 24;

inline std::int64_t now_us() {
  using namespace std::chrono;
  return duration_cast<microseconds>(steady_clock::now().time_since_epoch()).count();
}

// Bytes of a message with so many events, a multiple of kRows. An odd number of words:
// PackageWriter never asks for memory of such a size.
constexpr std::size_t bytes_of(std::size_t events) { return 2 * (events + 3 * kRows + 1); }

inline std::unique_ptr<EventPacket> message(std::size_t events, std::uint64_t seq,
                                            std::int64_t leaves_us) {
  auto packet = std::make_unique<EventPacket>();
  packet->header.frame_id = "camera";
  packet->header.stamp.sec = static_cast<std::int32_t>(leaves_us / 1'000'000);
  packet->header.stamp.nanosec = static_cast<std::uint32_t>(leaves_us % 1'000'000 * 1'000);
  packet->width = 640;
  packet->height = 480;
  packet->seq = seq;
  packet->encoding = "evt3";
  packet->events.resize(bytes_of(events));
  std::uint8_t* to = packet->events.data();
  const auto put = [&](std::uint32_t word) {
    *to++ = static_cast<std::uint8_t>(word & 0xff);
    *to++ = static_cast<std::uint8_t>(word >> 8);
  };
  for (std::size_t row = 0; row < kRows; ++row) {
    const std::int64_t t = leaves_us - static_cast<std::int64_t>(kRows - 1 - row);
    put(8u << 12 | static_cast<std::uint32_t>(t >> 12 & 0xfff));
    put(6u << 12 | static_cast<std::uint32_t>(t & 0xfff));
    put(static_cast<std::uint32_t>(row));
    for (std::size_t i = 0; i < events / kRows; ++i) {
      put(2u << 12 | static_cast<std::uint32_t>(i % 640));
    }
  }
  put(kRows - 1);  // a row without an event
  return packet;
}

// From the leaving of its message until now, us.
inline std::int64_t age_us(const asap::Event& event, std::int64_t now) {
  const std::int64_t left_us = event.t + static_cast<std::int64_t>(kRows) - 1 - event.y;
  return (now - left_us) & (kEvt3Range_us - 1);
}

inline ros::Packet packet_of(const EventPacket& message) {
  return {.publisher = "source",
          .sensor = {message.width, message.height},
          .seq = message.seq,
          .time_base = message.time_base,
          .encoding = message.encoding,
          .is_bigendian = message.is_bigendian,
          .bytes = std::as_bytes(std::span(message.events))};
}

}  // namespace asap_peers
