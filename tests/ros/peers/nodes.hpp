// Source, Relay, Sink: a driver, the least that stands between it and a consumer, and a consumer.
#pragma once

#include <algorithm>
#include <asap_ros/msg/processing_time.hpp>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <rclcpp/rclcpp.hpp>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "messages.hpp"

namespace asap_peers {

inline rclcpp::QoS qos() { return rclcpp::QoS(rclcpp::KeepLast(1000)).reliable(); }

// As metavision_driver and libcaer_driver publish.
inline rclcpp::QoS drivers_qos() { return qos().best_effort().durability_volatile(); }

struct Load {
  std::size_t events = 1'000;  // in a message
  std::size_t messages = 10'000;
  std::int64_t period_us = 1'000;  // 0: as fast as it can
};

// Publishes on `events`, on a thread of its own as drivers do, once `subscribers` are there.
class Source : public rclcpp::Node {
 public:
  Source(const Load& load, std::size_t subscribers, const rclcpp::NodeOptions& options)
      : Node("source", options), load_(load) {
    publisher_ = create_publisher<EventPacket>("events", drivers_qos());
    thread_ = std::jthread([this, subscribers](const std::stop_token& stop) {
      while (heard() < subscribers && !stop.stop_requested()) pause(10'000);
      pause(1'000'000);  // all have found each other
      play(stop);
    });
  }

  // The time that it took, s; 0: not yet.
  double seconds() const { return seconds_; }

 private:
  static constexpr std::int64_t kCalm_us = 500'000;

  static void pause(std::int64_t us) { std::this_thread::sleep_for(std::chrono::microseconds(us)); }

  std::size_t heard() const {
    return std::max(publisher_->get_subscription_count(),
                    publisher_->get_intra_process_subscription_count());
  }

  void play(const std::stop_token& stop) {
    const std::int64_t start_us = now_us();
    std::int64_t left_us = start_us;
    for (std::uint64_t i = 0; i < load_.messages && !stop.stop_requested(); ++i) {
      const std::int64_t due_us = start_us + static_cast<std::int64_t>(i) * load_.period_us;
      if (due_us > now_us()) pause(due_us - now_us());
      if (i + 1 == load_.messages) pause(kCalm_us);  // its number tells what was lost
      left_us = std::max(now_us(), left_us + static_cast<std::int64_t>(kRows));  // stamps grow
      publisher_->publish(message(load_.events, i, left_us));
    }
    seconds_ = static_cast<double>(now_us() - start_us - kCalm_us) * 1e-6;
  }

  const Load load_;
  rclcpp::Publisher<EventPacket>::SharedPtr publisher_;
  std::atomic<double> seconds_ = 0;
  std::jthread thread_;
};

class Relay : public rclcpp::Node {
 public:
  explicit Relay(const rclcpp::NodeOptions& options) : Node("relay", options) {
    publisher_ = create_publisher<EventPacket>("~/events", qos());
    subscription_ = create_subscription<EventPacket>(
        "events", drivers_qos(),
        [this](EventPacket::UniquePtr packet) { publisher_->publish(std::move(packet)); });
  }

 private:
  rclcpp::Publisher<EventPacket>::SharedPtr publisher_;
  rclcpp::Subscription<EventPacket>::SharedPtr subscription_;
};

// Reads what comes on `topic`, and notes how long it was on the way. Gives feedback on
// `finished_topic`, if there is one.
class Sink : public rclcpp::Node {
 public:
  Sink(const std::string& topic, const std::string& finished_topic,
       const rclcpp::NodeOptions& options)
      : Node("sink", options), ages_(static_cast<std::size_t>(kEvt3Range_us)) {
    if (!finished_topic.empty()) {
      finished_ = create_publisher<asap_ros::msg::ProcessingTime>(finished_topic, 10);
    }
    subscription_ = create_subscription<EventPacket>(
        topic, qos(), [this](EventPacket::ConstSharedPtr message) { take(*message); });
  }

  std::uint64_t events() const { return events_; }

  // The age that this share of the events has at most, us.
  std::int64_t quantile(double share) const {
    std::uint64_t below = 0;
    for (std::size_t age = 0; age < ages_.size(); ++age) {
      below += ages_[age];
      if (static_cast<double>(below) >= share * static_cast<double>(events_) && below > 0) {
        return static_cast<std::int64_t>(age);
      }
    }
    return 0;
  }

 private:
  void take(const EventPacket& message) {
    const std::int64_t now = now_us();
    const ros::Packet packet = packet_of(message);
    if (ros::refusal_of(packet)) return;
    reader_.see(packet);
    std::uint64_t count = 0;
    reader_.decode(packet, [&](asap::EventSpan events) {
      count += events.size();
      for (const asap::Event& event : events) ++ages_[static_cast<std::size_t>(age_us(event, now))];
    });
    events_ += count;
    if (!finished_) return;
    asap_ros::msg::ProcessingTime finished;
    finished.seq = message.seq;
    finished_->publish(finished);
  }

  ros::PacketReader reader_;
  std::vector<std::uint64_t> ages_;  // events by their age in us
  std::atomic<std::uint64_t> events_ = 0;
  rclcpp::Publisher<asap_ros::msg::ProcessingTime>::SharedPtr finished_;
  rclcpp::Subscription<EventPacket>::SharedPtr subscription_;
};

}  // namespace asap_peers
