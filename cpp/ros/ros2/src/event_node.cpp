#include "event_node.hpp"

#include <chrono>
#include <stdexcept>
#include <string_view>

#ifdef ASAP_ROS_DVS_MSGS
#include <dvs_msgs/msg/event_array.hpp>
#endif

namespace asap_ros {
namespace {

constexpr std::int64_t kNsPerS = 1'000'000'000;
constexpr int kLogEvery_ms = 1000;

// A number of any kind: `latency_ms:=20` is an integer to ROS.
double number_of(const rclcpp::Parameter& parameter) {
  if (parameter.get_type() == rclcpp::PARAMETER_DOUBLE) return parameter.as_double();
  if (parameter.get_type() == rclcpp::PARAMETER_INTEGER) {
    return static_cast<double>(parameter.as_int());
  }
  throw std::invalid_argument(parameter.get_name() + " = " + parameter.value_to_string() +
                              ": must be a number");
}

std::int64_t to_ns(const builtin_interfaces::msg::Time& time) {
  return std::int64_t{time.sec} * kNsPerS + time.nanosec;
}

}  // namespace

builtin_interfaces::msg::Time to_time(std::int64_t ns) {
  builtin_interfaces::msg::Time time;
  time.sec = static_cast<std::int32_t>(ns / kNsPerS);
  time.nanosec = static_cast<std::uint32_t>(ns % kNsPerS);
  return time;
}

EventNode::EventNode(const std::string& name, const rclcpp::NodeOptions& options)
    : Node(name, options) {
  declare(ros::kLatency);
  declare(ros::kPrefer);
  rcl_interfaces::msg::ParameterDescriptor fixed;
  fixed.read_only = true;
  fixed.description = "Subscribe and publish best effort: a slow network loses messages.";
  declare_parameter("best_effort", false, fixed);
  fixed.description = "Messages that wait in the middleware, on either side.";
  fixed.integer_range.resize(1);
  fixed.integer_range[0].from_value = 1;
  fixed.integer_range[0].to_value = 100'000;
  declare_parameter("queue", 1000, fixed);
  fixed.integer_range.clear();
  fixed.description = "Package of the messages on `events`: event_camera_msgs or dvs_msgs.";
  declare_parameter("input", std::string("event_camera_msgs"), fixed);
}

EventNode::~EventNode() { stop(); }

void EventNode::declare(const ros::NumberField& field) {
  rcl_interfaces::msg::ParameterDescriptor descriptor;
  descriptor.description = field.description;
  descriptor.dynamic_typing = true;
  descriptor.floating_point_range.resize(1);
  descriptor.floating_point_range[0].from_value = field.least;
  descriptor.floating_point_range[0].to_value = field.most;
  declare_parameter(field.name, rclcpp::ParameterValue(parameters_.*field.field), descriptor);
  parameters_.*field.field = number_of(get_parameter(field.name));
  numbers_.push_back(&field);
}

void EventNode::declare(const ros::ChoiceField& field) {
  rcl_interfaces::msg::ParameterDescriptor descriptor;
  descriptor.description = field.description;
  descriptor.read_only = true;
  parameters_.*field.field = declare_parameter(field.name, parameters_.*field.field, descriptor);
}

void EventNode::start(ros::Receiver& receiver) {
  session_ = std::make_unique<ros::Session>(parameters_, receiver, [this](const std::string& line) {
    RCLCPP_INFO(get_logger(), "%s", line.c_str());
  });
  stats_ = create_publisher<std_msgs::msg::String>("~/stats", 10);
  diagnostics_ = create_publisher<diagnostic_msgs::msg::DiagnosticArray>("/diagnostics", 10);
  watch_parameters();
  subscribe();
  timer_ = create_wall_timer(std::chrono::seconds(1), [this] { report(); });
  // While messages still leave: afterwards the context is no longer valid.
  on_shutdown_ = get_node_base_interface()->get_context()->add_pre_shutdown_callback(
      [this] { session_->stop(); });
}

void EventNode::stop() {
  if (on_shutdown_) {
    get_node_base_interface()->get_context()->remove_pre_shutdown_callback(*on_shutdown_);
    on_shutdown_.reset();
  }
  if (session_) session_->stop();
}

// ---- parameters -------------------------------------------------------------------------------

void EventNode::watch_parameters() {
  const auto changed = [this](const std::vector<rclcpp::Parameter>& given) {
    ros::Parameters next = parameters_;
    for (const rclcpp::Parameter& parameter : given) {
      for (const ros::NumberField* field : numbers_) {
        if (parameter.get_name() == field->name) next.*field->field = number_of(parameter);
      }
    }
    ros::check(next);
    return next;
  };
  on_set_ = add_on_set_parameters_callback([changed](const std::vector<rclcpp::Parameter>& given) {
    rcl_interfaces::msg::SetParametersResult result;
    result.successful = true;
    try {
      changed(given);
    } catch (const std::invalid_argument& error) {
      result.successful = false;
      result.reason = error.what();
    }
    return result;
  });
  post_set_ = add_post_set_parameters_callback(
      [this, changed](const std::vector<rclcpp::Parameter>& given) {
        parameters_ = changed(given);
        session_->set_latency(parameters_.latency_ms);
        heed(parameters_);
      });
}

rclcpp::QoS EventNode::qos() const {
  rclcpp::QoS qos(rclcpp::KeepLast(static_cast<std::size_t>(get_parameter("queue").as_int())));
  return get_parameter("best_effort").as_bool() ? qos.best_effort() : qos.reliable();
}

// ---- events -----------------------------------------------------------------------------------

void EventNode::subscribe() {
  const std::string input = get_parameter("input").as_string();
  if (input == "event_camera_msgs") {
    subscription_ = create_subscription<EventPacket>(
        "events", qos(),
        [this](EventPacket::ConstSharedPtr message, const rclcpp::MessageInfo& info) {
          take(*message, info);
        });
    return;
  }
#ifdef ASAP_ROS_DVS_MSGS
  if (input == "dvs_msgs") {
    using EventArray = dvs_msgs::msg::EventArray;
    subscription_ = create_subscription<EventArray>(
        "events", qos(),
        [this](EventArray::ConstSharedPtr message, const rclcpp::MessageInfo& info) {
          decoded_.clear();
          for (const auto& event : message->events) {
            decoded_.push_back({.x = event.x,
                                .y = event.y,
                                .p = static_cast<std::int16_t>(event.polarity),
                                .t = to_ns(event.ts) / 1000});
          }
          ros::Packet packet{.sensor = {message->width, message->height},
                             .encoding = ros::kDecoded,
                             .events = decoded_};
          take(packet, message->header, info);
        });
    return;
  }
  throw std::invalid_argument("input = " + input + ": must be event_camera_msgs or dvs_msgs");
#else
  throw std::invalid_argument("input = " + input +
                              ": must be event_camera_msgs; asap_ros was built without dvs_msgs");
#endif
}

void EventNode::take(const EventPacket& message, const rclcpp::MessageInfo& info) {
  ros::Packet packet{.sensor = {message.width, message.height},
                     .seq = message.seq,
                     .time_base = message.time_base,
                     .encoding = message.encoding,
                     .is_bigendian = message.is_bigendian,
                     .bytes = std::as_bytes(std::span(message.events))};
  take(packet, message.header, info);
}

void EventNode::take(ros::Packet& packet, const std_msgs::msg::Header& header,
                     const rclcpp::MessageInfo& info) {
  const auto& gid = info.get_rmw_message_info().publisher_gid.data;
  packet.publisher = {reinterpret_cast<const char*>(gid), sizeof gid};
  {
    const std::lock_guard lock(frame_);
    if (frame_id_ != header.frame_id) frame_id_ = header.frame_id;
  }
  const std::optional<ros::Refusal> refusal = session_->take(packet, to_ns(header.stamp));
  if (!refusal) return;
  RCLCPP_WARN_THROTTLE(get_logger(), *get_clock(), kLogEvery_ms, "%s",
                       ros::sentence(*refusal, packet).c_str());
}

std_msgs::msg::Header EventNode::header(std::int64_t stamp_ns) const {
  std_msgs::msg::Header header;
  header.stamp = to_time(stamp_ns);
  const std::lock_guard lock(frame_);
  header.frame_id = frame_id_;
  return header;
}

// ---- reports ----------------------------------------------------------------------------------

void EventNode::report() {
  ros::Facts facts = session_->facts();
  const ros::Facts more = this->facts();
  facts.insert(facts.end(), more.begin(), more.end());
  std_msgs::msg::String stats;
  stats.data = ros::to_json(facts);
  stats_->publish(stats);

  const std::string trouble = session_->trouble(subscription_->get_topic_name());
  diagnostic_msgs::msg::DiagnosticStatus status;
  status.name = get_fully_qualified_name();
  status.level = trouble.empty() ? status.OK : status.WARN;
  status.message = trouble.empty() ? "ok" : trouble;
  for (const auto& [name, value] : facts) {
    diagnostic_msgs::msg::KeyValue entry;
    entry.key = name;
    entry.value = value;
    status.values.push_back(entry);
  }
  diagnostic_msgs::msg::DiagnosticArray array;
  array.header.stamp = now();
  array.status.push_back(status);
  diagnostics_->publish(array);
}

}  // namespace asap_ros
