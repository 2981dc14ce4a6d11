// ClusterTrackerNode: an algorithm in the node itself. Events go from the subscription to
// ClusterTracker without another message; ~/clusters has its clusters as a PointCloud2 in px. A
// component of your own is this file with your process(EventSpan).
#pragma once

#include <chrono>
#include <optional>
#include <sensor_msgs/msg/point_cloud2.hpp>
#include <vector>

#include "asap/algorithms/cluster_tracker.hpp"
#include "event_node.hpp"

namespace asap_ros {

class ClusterTrackerNode : public EventNode, private ros::Receiver {
 public:
  explicit ClusterTrackerNode(const rclcpp::NodeOptions& options);
  ~ClusterTrackerNode() override;

 private:
  using PointCloud2 = sensor_msgs::msg::PointCloud2;

  asap::Execution execution() const noexcept override { return asap::Execution::anytime; }
  void begin(const ros::Geometry& sensor) override;
  void process(const asap::Package& package, std::int64_t stamp_ns) override;
  void publish(std::int64_t stamp_ns);

  rclcpp::Publisher<PointCloud2>::SharedPtr publisher_;
  std::optional<asap::ClusterTracker> tracker_;
  std::vector<asap::Cluster> clusters_;
  std::chrono::steady_clock::time_point published_{};
};

}  // namespace asap_ros
