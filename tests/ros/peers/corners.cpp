// More cores before fewer events: a node of one's own whose corner detector works on as many
// threads as the parameter `threads` says. ~/corners has the number of corners so far.
#include <event_node.hpp>
#include <optional>
#include <std_msgs/msg/u_int64.hpp>

#include "asap/algorithms/corner_detector.hpp"
#include "asap/runner/tiled.hpp"

class Corners : public asap_ros::EventNode, private asap::ros::Receiver {
 public:
  explicit Corners(const rclcpp::NodeOptions& options) : EventNode("corners", options) {
    threads_ = static_cast<int>(declare_parameter<std::int64_t>("threads", 2));
    publisher_ = create_publisher<std_msgs::msg::UInt64>("~/corners", 10);
    start(*this);
  }
  ~Corners() override { stop(); }

 private:
  void begin(const asap::ros::Geometry& sensor) override {
    const asap::EHarrisConfig config{.width = static_cast<int>(sensor.width),
                                     .height = static_cast<int>(sensor.height)};
    detector_.emplace(config, asap::TiledConfig{.threads = threads_});
  }

  void process(const asap::Package& package, std::int64_t) override {
    labels_.resize(package.events.size());
    detector_->process(package.events, std::span(labels_));
    for (const std::uint8_t label : labels_) corners_.data += label;
    publisher_->publish(corners_);
  }

  int threads_;
  std::optional<asap::Tiled<asap::EHarris>> detector_;
  std::vector<std::uint8_t> labels_;
  rclcpp::Publisher<std_msgs::msg::UInt64>::SharedPtr publisher_;
  std_msgs::msg::UInt64 corners_;
};

int main(int argc, char** argv) { return asap_ros::spin<Corners>(argc, argv); }
