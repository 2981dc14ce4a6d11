#include "cluster_tracker_node.hpp"

#include <cstring>
#include <rclcpp_components/register_node_macro.hpp>
#include <utility>

namespace asap_ros {
namespace {

constexpr auto kPublishEvery = std::chrono::milliseconds(10);

// A point as its fields say.
struct Point {
  float x, y, z, vx, vy;
  std::int32_t id;
  std::uint32_t size;
};

using Field = sensor_msgs::msg::PointField;

Field field(const char* name, std::size_t offset, std::uint8_t type = Field::FLOAT32) {
  Field field;
  field.name = name;
  field.offset = static_cast<std::uint32_t>(offset);
  field.datatype = type;
  field.count = 1;
  return field;
}

}  // namespace

ClusterTrackerNode::ClusterTrackerNode(const rclcpp::NodeOptions& options)
    : EventNode("asap_cluster_tracker", options) {
  publisher_ = create_publisher<PointCloud2>("~/clusters", 10);
  start(*this);
}

ClusterTrackerNode::~ClusterTrackerNode() { stop(); }

void ClusterTrackerNode::begin(const ros::Geometry& sensor) {
  tracker_.emplace(asap::ClusterTrackerConfig{.width = static_cast<int>(sensor.width),
                                              .height = static_cast<int>(sensor.height)});
}

void ClusterTrackerNode::process(const asap::Package& package, std::int64_t stamp_ns) {
  tracker_->set_keep(package.keep);
  tracker_->process(package.events);
  const auto now = std::chrono::steady_clock::now();
  if (now - published_ < kPublishEvery) return;
  published_ = now;
  publish(stamp_ns + (package.t_last() - package.t_first()) * 1000);
}

void ClusterTrackerNode::publish(std::int64_t stamp_ns) {
  tracker_->clusters(clusters_);
  auto cloud = std::make_unique<PointCloud2>();
  cloud->header = header(stamp_ns);
  cloud->height = 1;
  cloud->width = static_cast<std::uint32_t>(clusters_.size());
  cloud->fields = {field("x", offsetof(Point, x)),
                   field("y", offsetof(Point, y)),
                   field("z", offsetof(Point, z)),
                   field("vx", offsetof(Point, vx)),
                   field("vy", offsetof(Point, vy)),
                   field("id", offsetof(Point, id), Field::INT32),
                   field("size", offsetof(Point, size), Field::UINT32)};
  cloud->point_step = sizeof(Point);
  cloud->row_step = cloud->point_step * cloud->width;
  cloud->is_dense = true;
  cloud->data.resize(cloud->row_step);
  std::uint8_t* to = cloud->data.data();
  for (const asap::Cluster& cluster : clusters_) {
    const Point point{static_cast<float>(cluster.x),
                      static_cast<float>(cluster.y),
                      0.0F,
                      static_cast<float>(cluster.vx),
                      static_cast<float>(cluster.vy),
                      static_cast<std::int32_t>(cluster.id),
                      static_cast<std::uint32_t>(cluster.size)};
    std::memcpy(to, &point, sizeof point);
    to += sizeof point;
  }
  publisher_->publish(std::move(cloud));
}

}  // namespace asap_ros

RCLCPP_COMPONENTS_REGISTER_NODE(asap_ros::ClusterTrackerNode)
