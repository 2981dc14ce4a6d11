// EventNode: what the nodes have in common: events of a topic go into a Session, which works for a
// receiver; ~/stats and /diagnostics say once a second how it does. Declares the parameters that
// every node has.
//
// The callbacks of a node run one at a time; the receiver runs on the session's thread.
#pragma once

#include <cstdint>
#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <event_camera_msgs/msg/event_packet.hpp>
#include <memory>
#include <optional>
#include <rclcpp/rclcpp.hpp>
#include <std_msgs/msg/header.hpp>
#include <std_msgs/msg/string.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "ros/bridge/parameters.hpp"
#include "ros/bridge/session.hpp"

namespace asap_ros {

namespace ros = asap::ros;
using EventPacket = event_camera_msgs::msg::EventPacket;

builtin_interfaces::msg::Time to_time(std::int64_t ns);

class EventNode : public rclcpp::Node {
 public:
  EventNode(const std::string& name, const rclcpp::NodeOptions& options);
  ~EventNode() override;

 protected:
  // Declares the parameters of a node that publishes packages as well.
  void declare_packages() {
    parameters_.feedback = ros::Parameters().feedback;
    declare(true);
  }

  // Once the receiver is there and all parameters are declared; throws std::invalid_argument for
  // bad ones. `packages`, if any, is where the receiver publishes. The receiver outlives stop().
  void start(ros::Receiver& receiver, rclcpp::PublisherBase::SharedPtr packages = {});
  void stop();

  const ros::Parameters& parameters() const noexcept { return parameters_; }
  std_msgs::msg::Header header(std::int64_t stamp_ns) const;
  // The node that publishes on a topic with these bytes as its identity.
  std::string name_of(const std::string& topic, std::string_view publisher) const;
  rclcpp::QoS qos(const std::string& reliability) const;

 private:
  void declare(bool of_packages);
  ros::Parameters declared() const;
  void refuse_misspelt();
  void subscribe();
  void tell_apart();
  void take(ros::Packet packet, const std_msgs::msg::Header& header,
            const rclcpp::MessageInfo& info);
  std::string mismatch() const;
  void report();

  ros::Parameters parameters_;
  std::unique_ptr<ros::Session> session_;
  std::vector<asap::Event> decoded_;
  std::string topic_;
  bool is_apart_ = false;  // several publishers: no message comes within the process
  rclcpp::SubscriptionBase::SharedPtr subscription_;
  rclcpp::PublisherBase::SharedPtr packages_;
  rclcpp::Publisher<std_msgs::msg::String>::SharedPtr stats_;
  rclcpp::Publisher<diagnostic_msgs::msg::DiagnosticArray>::SharedPtr diagnostics_;
  rclcpp::TimerBase::SharedPtr timer_;
  OnSetParametersCallbackHandle::SharedPtr on_set_;
  std::optional<rclcpp::PreShutdownCallbackHandle> on_shutdown_;
};

// main() of an executable with one node: 0 after SIGINT, 2 for bad parameters.
template <class Made>
int spin(int argc, char** argv) {
  rclcpp::init(argc, argv);
  int code = 0;
  try {
    rclcpp::spin(std::make_shared<Made>(rclcpp::NodeOptions()));
  } catch (const std::exception& error) {
    RCLCPP_FATAL(rclcpp::get_logger("asap"), "%s", error.what());
    code = 2;
  }
  rclcpp::shutdown();
  return code;
}

}  // namespace asap_ros
