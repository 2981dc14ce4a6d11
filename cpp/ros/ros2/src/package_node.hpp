// PackageNode: publishes the events of a camera in packages, on ~/events, as fast as the consumer
// works and within latency_ms. The consumer says when it has finished a package: see `feedback`.
#pragma once

#include <asap_ros/msg/processing_time.hpp>
#include <asap_ros/srv/feedback.hpp>
#include <functional>
#include <memory>

#include "event_node.hpp"
#include "ros/bridge/relay.hpp"

namespace asap_ros {

class PackageNode : public EventNode {
 public:
  explicit PackageNode(const rclcpp::NodeOptions& options);
  ~PackageNode() override;

 private:
  using Service = asap_ros::srv::Feedback;
  using ProcessingTime = asap_ros::msg::ProcessingTime;

  void advertise();
  void listen();
  void heed(const ros::Parameters& parameters) override { relay_->set(parameters); }
  ros::Facts facts() const override { return relay_->facts(); }

  std::function<void(ros::Message&)> publish_;
  rclcpp::PublisherBase::SharedPtr publisher_;
  std::unique_ptr<ros::Relay> relay_;
  rclcpp::Subscription<ProcessingTime>::SharedPtr processing_time_;
  rclcpp::Service<Service>::SharedPtr service_;
};

}  // namespace asap_ros
