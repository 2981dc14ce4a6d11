#include "event_node.hpp"

#include <algorithm>
#include <chrono>
#include <stdexcept>

#ifdef ASAP_ROS_DVS_MSGS
#include <dvs_msgs/msg/event_array.hpp>
#endif

namespace asap_ros {
namespace {

constexpr std::int64_t kNsPerS = 1'000'000'000;

std::int64_t to_ns(const builtin_interfaces::msg::Time& time) {
  return std::int64_t{time.sec} * kNsPerS + time.nanosec;
}

// By the clock of the middleware.
std::int64_t wall_ns() {
  return std::chrono::nanoseconds(std::chrono::system_clock::now().time_since_epoch()).count();
}

std::string name_of(const rclcpp::TopicEndpointInfo& end) {
  return end.node_namespace() + (end.node_namespace() == "/" ? "" : "/") + end.node_name();
}

void read(const rclcpp::Parameter& given, ros::Parameters& parameters) {
  std::optional<double> number;
  if (given.get_type() == rclcpp::PARAMETER_DOUBLE) number = given.as_double();
  if (given.get_type() == rclcpp::PARAMETER_INTEGER) {  // `latency_ms:=20`
    number = static_cast<double>(given.as_int());
  }
  ros::set(parameters, given.get_name(), given.value_to_string(), number);
}

}  // namespace

builtin_interfaces::msg::Time to_time(std::int64_t ns) {
  builtin_interfaces::msg::Time time;
  time.sec = static_cast<std::int32_t>(ns / kNsPerS);
  time.nanosec = static_cast<std::uint32_t>(ns % kNsPerS);
  return time;
}

EventNode::EventNode(const std::string& name, const rclcpp::NodeOptions& options)
    : Node(name, options), parameters_{.feedback = "none"} {
  declare(false);
}

EventNode::~EventNode() { stop(); }

void EventNode::start(ros::Receiver& receiver, rclcpp::PublisherBase::SharedPtr packages) {
  refuse_misspelt();
  const auto say = [this](ros::Level level, const std::string& line) {
    if (level == ros::Level::ok) RCLCPP_INFO(get_logger(), "%s", line.c_str());
    if (level == ros::Level::warn) RCLCPP_WARN(get_logger(), "%s", line.c_str());
    if (level == ros::Level::error) RCLCPP_ERROR(get_logger(), "%s", line.c_str());
  };
  session_ = std::make_unique<ros::Session>(
      parameters_, receiver, say, [this](std::string_view gid) { return name_of(topic_, gid); });
  packages_ = std::move(packages);
  stats_ = create_publisher<std_msgs::msg::String>("~/stats", 10);
  diagnostics_ = create_publisher<diagnostic_msgs::msg::DiagnosticArray>("/diagnostics", 10);
  on_set_ = add_on_set_parameters_callback([this](const std::vector<rclcpp::Parameter>& given) {
    rcl_interfaces::msg::SetParametersResult result;
    result.successful = true;
    try {
      ros::Parameters next = declared();
      for (const rclcpp::Parameter& parameter : given) read(parameter, next);
      ros::check(next);
    } catch (const std::invalid_argument& error) {
      result.successful = false;
      result.reason = error.what();
    }
    return result;
  });
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

// Reads the declared parameters: all that were accepted, in force or not.
ros::Parameters EventNode::declared() const {
  ros::Parameters parameters = parameters_;
  const auto look = [&](const auto& field) {
    if (has_parameter(field.name)) read(get_parameter(field.name), parameters);
  };
  for (const ros::NumberField& field : ros::kNumbers) look(field);
  for (const ros::ChoiceField& field : ros::kChoices) look(field);
  return parameters;
}

void EventNode::refuse_misspelt() {
  for (const auto& [name, value] : get_node_parameters_interface()->get_parameter_overrides()) {
    if (has_parameter(name) || !ros::is_foreign(name, rclcpp::to_string(value))) continue;
    RCLCPP_INFO(get_logger(), "ignored, not a parameter of this node: %s", name.c_str());
  }
}

void EventNode::declare(bool of_packages) {
  rcl_interfaces::msg::ParameterDescriptor descriptor;
  descriptor.dynamic_typing = true;  // so that it is our check that refuses, with value and remedy
  const auto declare_one = [&](const auto& field, bool is_fixed) {
    if (ros::is_of_packages(field.has) != of_packages) return;
    descriptor.read_only = is_fixed;
    descriptor.description = field.description;
    descriptor.additional_constraints = "Must be " + ros::constraint(field) + ".";
    declare_parameter(field.name, rclcpp::ParameterValue(parameters_.*field.field), descriptor);
    read(get_parameter(field.name), parameters_);
  };
  for (const ros::NumberField& field : ros::kNumbers) declare_one(field, field.is_fixed);
  for (const ros::ChoiceField& field : ros::kChoices) declare_one(field, true);
}

rclcpp::QoS EventNode::qos(const std::string& reliability) const {
  rclcpp::QoS qos(rclcpp::KeepLast(static_cast<std::size_t>(parameters_.queue)));
  return reliability == "reliable" ? qos.reliable() : qos.best_effort();
}

// ---- events -----------------------------------------------------------------------------------

void EventNode::subscribe() {
  const rclcpp::QoS qos = this->qos(parameters_.input_reliability);
  rclcpp::SubscriptionOptions options;
  if (is_apart_) options.use_intra_process_comm = rclcpp::IntraProcessSetting::Disable;
  if (parameters_.input == "event_camera_msgs") {
    subscription_ = create_subscription<EventPacket>(
        "events", qos,
        [this](EventPacket::ConstSharedPtr message, const rclcpp::MessageInfo& info) {
          take({.sensor = {message->width, message->height},
                .seq = message->seq,
                .time_base = message->time_base,
                .encoding = message->encoding,
                .is_bigendian = message->is_bigendian,
                .bytes = std::as_bytes(std::span(message->events))},
               message->header, info);
        },
        options);
  } else {
#ifdef ASAP_ROS_DVS_MSGS
    using EventArray = dvs_msgs::msg::EventArray;
    subscription_ = create_subscription<EventArray>(
        "events", qos,
        [this](EventArray::ConstSharedPtr message, const rclcpp::MessageInfo& info) {
          decoded_.clear();
          for (const auto& event : message->events) {
            decoded_.push_back({.x = event.x,
                                .y = event.y,
                                .p = static_cast<std::int16_t>(event.polarity),
                                .t = to_ns(event.ts) / 1000});
          }
          take({.sensor = {message->width, message->height},
                .encoding = ros::kDecoded,
                .events = decoded_},
               message->header, info);
        },
        options);
#else
    throw std::invalid_argument("input = " + parameters_.input +
                                ": must be event_camera_msgs; asap_ros was built without dvs_msgs");
#endif
  }
  topic_ = subscription_->get_topic_name();
}

void EventNode::take(ros::Packet packet, const std_msgs::msg::Header& header,
                     const rclcpp::MessageInfo& info) {
  const rmw_message_info_t& about = info.get_rmw_message_info();
  if (!about.from_intra_process) {  // else it has neither
    packet.publisher = {reinterpret_cast<const char*>(about.publisher_gid.data),
                        sizeof about.publisher_gid.data};
    packet.waited_ns = wall_ns() - about.received_timestamp;
  }
  packet.frame_id = header.frame_id;
  packet.stamp_ns = to_ns(header.stamp);
  session_->take(packet);
}

std_msgs::msg::Header EventNode::header(std::int64_t stamp_ns) const {
  std_msgs::msg::Header header;
  header.stamp = to_time(stamp_ns);
  header.frame_id = session_->frame_id();
  return header;
}

// ---- reports ----------------------------------------------------------------------------------

std::string EventNode::name_of(const std::string& topic, std::string_view publisher) const {
  for (const rclcpp::TopicEndpointInfo& end : get_publishers_info_by_topic(topic)) {
    const auto& gid = end.endpoint_gid();
    if (std::equal(gid.begin(), gid.end(), publisher.begin(), publisher.end(),
                   [](auto a, char b) { return a == static_cast<std::uint8_t>(b); })) {
      return asap_ros::name_of(end);
    }
  }
  return "a publisher that has gone";
}

std::string EventNode::mismatch() const {
  std::string found;
  const auto look = [&](const auto& end, const auto& offered, const auto& asked, const char* what) {
    const auto fit = rclcpp::qos_check_compatible(offered, asked);
    if (fit.compatibility == rclcpp::QoSCompatibility::Error)
      found = asap_ros::name_of(end) + what + fit.reason;
  };
  for (const rclcpp::TopicEndpointInfo& end : get_publishers_info_by_topic(topic_)) {
    look(end, end.qos_profile(), subscription_->get_actual_qos(),
         " is not heard; change input_reliability: ");
  }
  if (!packages_) return found;
  for (const auto& end : get_subscriptions_info_by_topic(packages_->get_topic_name())) {
    look(end, packages_->get_actual_qos(), end.qos_profile(),
         " hears nothing; change output_reliability: ");
  }
  return found;
}

// Messages within a process do not say who published them, those over DDS do.
void EventNode::tell_apart() {
  if (is_apart_ || count_publishers(topic_) < 2) return;
  is_apart_ = true;
  subscribe();
}

void EventNode::report() {
  tell_apart();
  session_->set(declared());
  const ros::Session::Report report = session_->report(topic_, mismatch());
  std_msgs::msg::String stats;
  stats.data = ros::to_json(report.facts);
  stats_->publish(stats);
  diagnostic_msgs::msg::DiagnosticArray array;
  array.header.stamp = now();
  ros::write(report, get_fully_qualified_name(), array.status.emplace_back());
  diagnostics_->publish(array);
}

}  // namespace asap_ros
