// PackageNode: publishes the events of a camera in packages, on ~/events, as fast as the consumer
// works and within latency_ms. The consumer says when it has finished a package: see `feedback`.
#include <rclcpp/version.h>

#include <algorithm>
#include <asap_ros/msg/processing_time.hpp>
#include <asap_ros/srv/feedback.hpp>
#include <functional>
#include <memory>
#include <rclcpp_components/register_node_macro.hpp>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "event_node.hpp"
#include "ros/bridge/relay.hpp"

#ifdef ASAP_ROS_DVS_MSGS
#include <dvs_msgs/msg/event_array.hpp>
#endif

namespace asap_ros {

class PackageNode : public EventNode {
 public:
  explicit PackageNode(const rclcpp::NodeOptions& options) : EventNode("asap", options) {
    declare_packages();
    advertise();
    relay_ = std::make_unique<ros::Relay>(
        parameters(), publish_, [this] { return consumers(); },
        [this](std::string_view id) { return consumer(id); });
    listen();
    start(*relay_, publisher_);
  }
  ~PackageNode() override { stop(); }

 private:
  using Service = asap_ros::srv::Feedback;
  using ProcessingTime = asap_ros::msg::ProcessingTime;
  static constexpr std::size_t kCallsThatWait = 1000;  // 10 by default: a burst would lose some

  void advertise() {
    const rclcpp::QoS qos = this->qos(parameters().output_reliability);
    if (parameters().encoding != ros::kDecoded) {
      const auto publisher = create_publisher<EventPacket>("~/events", qos);
      publisher_ = publisher;
      publish_ = [this, publisher = publisher.get()](ros::Message& message) {
        auto packet = std::make_unique<EventPacket>();
        packet->header = header(message.stamp_ns);
        packet->width = message.sensor.width;
        packet->height = message.sensor.height;
        packet->seq = message.seq;
        packet->time_base = message.time_base;
        packet->encoding = message.encoding;
        packet->events = std::move(message.bytes);
        publisher->publish(std::move(packet));
      };
      return;
    }
#ifdef ASAP_ROS_DVS_MSGS
    using EventArray = dvs_msgs::msg::EventArray;
    const auto publisher = create_publisher<EventArray>("~/events", qos);
    publisher_ = publisher;
    publish_ = [this, publisher = publisher.get()](ros::Message& message) {
      auto array = std::make_unique<EventArray>();
      array->header = header(message.stamp_ns);
      array->width = message.sensor.width;
      array->height = message.sensor.height;
      array->events.reserve(message.events.size());
      for (const asap::Event& event : message.events) {
        auto& to = array->events.emplace_back();
        to.x = event.x;
        to.y = event.y;
        to.ts = to_time(event.t * 1000);
        to.polarity = event.p > 0;
      }
      publisher->publish(std::move(array));
    };
#else
    throw std::invalid_argument(
        "encoding = dvs_msgs: must be evt3 or mono; asap_ros was built without dvs_msgs");
#endif
  }

  void listen() {
    if (parameters().feedback == "topic") {
      processing_time_ = create_subscription<ProcessingTime>(
          "~/processing_time", 10,
          [this](ProcessingTime::ConstSharedPtr finished, const rclcpp::MessageInfo& info) {
            relay_->feedback(bytes_of(info.get_rmw_message_info().publisher_gid.data),
                             finished->seq, finished->time);
          });
    }
    if (parameters().feedback == "service") {
      auto qos = rclcpp::ServicesQoS().keep_last(kCallsThatWait);
      service_ = create_service<Service>(
          "~/feedback",
          [this](std::shared_ptr<rmw_request_id_t> call, Service::Request::SharedPtr request,
                 Service::Response::SharedPtr response) {
            response->success =
                relay_->feedback(bytes_of(call->writer_guid), request->seq, request->time);
          },
#if RCLCPP_VERSION_GTE(17, 0, 0)
          qos);
#else  // Humble
          qos.get_rmw_qos_profile());
#endif
    }
  }

  template <class Id>
  static std::string_view bytes_of(const Id& id) {
    return {reinterpret_cast<const char*>(id), sizeof id};
  }

  ros::Consumers consumers() const {
    const std::size_t heard = std::max(publisher_->get_subscription_count(),
                                       publisher_->get_intra_process_subscription_count());
    return {.heard = heard,
            .answering = processing_time_ ? processing_time_->get_publisher_count() : heard};
  }

  std::string consumer(std::string_view id) const {
    return processing_time_ ? name_of(processing_time_->get_topic_name(), id) : "a client";
  }

  std::function<void(ros::Message&)> publish_;
  rclcpp::PublisherBase::SharedPtr publisher_;
  std::unique_ptr<ros::Relay> relay_;
  rclcpp::Subscription<ProcessingTime>::SharedPtr processing_time_;
  rclcpp::Service<Service>::SharedPtr service_;
};

int asap_node(int argc, char** argv) { return spin<PackageNode>(argc, argv); }

}  // namespace asap_ros

RCLCPP_COMPONENTS_REGISTER_NODE(asap_ros::PackageNode)
