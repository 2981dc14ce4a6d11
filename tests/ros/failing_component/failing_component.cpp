#include <event_node.hpp>
#include <rclcpp_components/register_node_macro.hpp>
#include <stdexcept>

class FailingNode : public asap_ros::EventNode, private asap::ros::Receiver {
 public:
  explicit FailingNode(const rclcpp::NodeOptions& options) : EventNode("failing", options) {
    start(*this);
  }
  ~FailingNode() override { stop(); }

 private:
  void process(const asap::Package&, std::int64_t) override { throw std::runtime_error("no room"); }
};

RCLCPP_COMPONENTS_REGISTER_NODE(FailingNode)
