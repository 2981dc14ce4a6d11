// ClusterTrackerNode: an algorithm in the node itself. Events go from the subscription to
// ClusterTracker without another message; ~/clusters has its clusters as a PointCloud2 in px.
#include <chrono>
#include <cstring>
#include <optional>
#include <rclcpp_components/register_node_macro.hpp>
#include <sensor_msgs/msg/point_cloud2.hpp>
#include <utility>
#include <vector>

#include "asap/algorithms/cluster_tracker.hpp"
#include "event_node.hpp"

namespace asap_ros {

class ClusterTrackerNode : public EventNode, private ros::Receiver {
 public:
  explicit ClusterTrackerNode(const rclcpp::NodeOptions& options)
      : EventNode("asap_cluster_tracker", options) {
    publisher_ = create_publisher<PointCloud2>("~/clusters", 10);
    start(*this);
  }
  ~ClusterTrackerNode() override { stop(); }

 private:
  using PointCloud2 = sensor_msgs::msg::PointCloud2;
  using Clock = std::chrono::steady_clock;
  static constexpr auto kPublishEvery = std::chrono::milliseconds(10);

  struct Point {
    float x, y, z, vx, vy;
    std::int32_t id;
    std::uint32_t size;
  };

  asap::Execution execution() const noexcept override { return asap::Execution::anytime; }

  void begin(const ros::Geometry& sensor) override {
    tracker_.emplace(asap::ClusterTrackerConfig{.width = static_cast<int>(sensor.width),
                                                .height = static_cast<int>(sensor.height)});
  }

  void process(const asap::Package& package, std::int64_t stamp_ns) override {
    tracker_->set_gamma(package.gamma);
    tracker_->process(package.events);
    const auto now = Clock::now();
    if (now - published_ < kPublishEvery) return;
    published_ = now;
    publish(stamp_ns + (package.t_last() - package.t_first()) * 1000);
  }

  void publish(std::int64_t stamp_ns) {
    using Field = sensor_msgs::msg::PointField;
    tracker_->clusters(clusters_);
    auto cloud = std::make_unique<PointCloud2>();
    cloud->header = header(stamp_ns);
    cloud->height = 1;
    cloud->width = static_cast<std::uint32_t>(clusters_.size());
    for (const char* name : {"x", "y", "z", "vx", "vy", "id", "size"}) {
      Field& field = cloud->fields.emplace_back();
      field.name = name;
      field.offset = static_cast<std::uint32_t>(sizeof(float) * (cloud->fields.size() - 1));
      field.datatype = Field::FLOAT32;
      field.count = 1;
    }
    cloud->fields[5].datatype = Field::INT32;
    cloud->fields[6].datatype = Field::UINT32;
    cloud->point_step = sizeof(Point);
    cloud->row_step = cloud->point_step * cloud->width;
    cloud->is_dense = true;
    cloud->data.resize(cloud->row_step);
    std::uint8_t* to = cloud->data.data();
    for (const asap::Cluster& cluster : clusters_) {
      Point point{};
      point.id = static_cast<std::int32_t>(cluster.id);
      point.x = static_cast<float>(cluster.x);
      point.y = static_cast<float>(cluster.y);
      point.vx = static_cast<float>(cluster.vx);
      point.vy = static_cast<float>(cluster.vy);
      point.size = static_cast<std::uint32_t>(cluster.size);
      std::memcpy(to, &point, sizeof point);
      to += sizeof point;
    }
    publisher_->publish(std::move(cloud));
  }

  rclcpp::Publisher<PointCloud2>::SharedPtr publisher_;
  std::optional<asap::ClusterTracker> tracker_;
  std::vector<asap::Cluster> clusters_;
  Clock::time_point published_{};
};

int cluster_tracker(int argc, char** argv) { return spin<ClusterTrackerNode>(argc, argv); }

}  // namespace asap_ros

RCLCPP_COMPONENTS_REGISTER_NODE(asap_ros::ClusterTrackerNode)
