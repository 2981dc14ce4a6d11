#include <event_node.hpp>
#include <rclcpp_components/register_node_macro.hpp>
#include <std_msgs/msg/u_int64.hpp>

class OwnNode : public asap_ros::EventNode, private asap::ros::Receiver {
 public:
  explicit OwnNode(const rclcpp::NodeOptions& options) : EventNode("own", options) {
    publisher_ = create_publisher<std_msgs::msg::UInt64>("~/on_events", 10);
    start(*this);
  }
  ~OwnNode() override { stop(); }

 private:
  // The algorithm; not on the thread of the callbacks.
  void process(const asap::Package& package, std::int64_t) override {
    for (const asap::Event& event : package.events) on_events_.data += event.p > 0;
    publisher_->publish(on_events_);
  }

  rclcpp::Publisher<std_msgs::msg::UInt64>::SharedPtr publisher_;
  std_msgs::msg::UInt64 on_events_;
};

RCLCPP_COMPONENTS_REGISTER_NODE(OwnNode)
