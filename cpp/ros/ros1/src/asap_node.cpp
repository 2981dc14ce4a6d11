// The node in roscpp: topics, a service, parameters and signals around a session and its relay.
#include <asap_ros/Feedback.h>
#include <asap_ros/ProcessingTime.h>
#include <diagnostic_msgs/DiagnosticArray.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <ros/xmlrpc_manager.h>
#include <std_msgs/String.h>

#include <algorithm>
#include <csignal>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "asap/core/result.hpp"
#include "ros/bridge/relay.hpp"
#include "ros/bridge/ros1_messages.hpp"
#include "ros/bridge/session.hpp"

namespace asap_ros {

// A message of any type, as bytes.
struct AnyMessage {
  std::vector<std::uint8_t> bytes;
};

// For messages with texts, which want a member of std::allocator that C++20 took away.
template <class T>
struct Allocator : std::allocator<T> {
  template <class U>
  struct rebind {
    using other = Allocator<U>;
  };
  Allocator() = default;
  template <class U>
  Allocator(const Allocator<U>&) noexcept {}
};

}  // namespace asap_ros

namespace ros::message_traits {

struct AnyType {
  static const char* value() { return "*"; }
  static const char* value(const asap_ros::AnyMessage&) { return "*"; }
};
template <>
struct IsMessage<asap_ros::AnyMessage> : TrueType {};
template <>
struct MD5Sum<asap_ros::AnyMessage> : AnyType {};
template <>
struct DataType<asap_ros::AnyMessage> : AnyType {};
template <>
struct Definition<asap_ros::AnyMessage> : AnyType {};

}  // namespace ros::message_traits

template <>
struct ros::serialization::Serializer<asap_ros::AnyMessage> {
  template <class Stream>
  static void write(Stream& stream, const asap_ros::AnyMessage& message) {
    std::ranges::copy(message.bytes, stream.advance(serializedLength(message)));
  }
  template <class Stream>
  static void read(Stream& stream, asap_ros::AnyMessage& message) {
    message.bytes.assign(stream.getData(), stream.getData() + stream.getLength());
  }
  static std::uint32_t serializedLength(const asap_ros::AnyMessage& message) {
    return static_cast<std::uint32_t>(message.bytes.size());
  }
};

namespace asap_ros {
namespace {

namespace bridge = asap::ros;
using Diagnostics = diagnostic_msgs::DiagnosticArray_<Allocator<void>>;
using String = std_msgs::String_<Allocator<void>>;

constexpr double kLookEvery_s = 0.05;  // whether a signal has come

// roscpp closes the topics at once when a signal or `rosnode kill` comes. The node ends itself, so
// that what waits is still delivered.
volatile std::sig_atomic_t is_ready = 0;
volatile std::sig_atomic_t is_over = 0;

void end(int) {
  is_over = 1;
  if (is_ready == 0) ros::requestShutdown();  // it may wait for the master
}

void end_by_call(XmlRpc::XmlRpcValue&, XmlRpc::XmlRpcValue& answer) {
  is_over = 1;
  answer = ros::xmlrpc::responseInt(1, "", 0);
}

void say(bridge::Level level, const std::string& line) {
  if (level == bridge::Level::ok) ROS_INFO("%s", line.c_str());
  if (level == bridge::Level::warn) ROS_WARN("%s", line.c_str());
  if (level == bridge::Level::error) ROS_ERROR("%s", line.c_str());
}

std::string text_of(XmlRpc::XmlRpcValue& value) {
  if (value.getType() == value.TypeString) return value;
  if (value.getType() == value.TypeInt) return std::to_string(static_cast<int>(value));
  if (value.getType() == value.TypeDouble) return bridge::to_text(value);
  return value.toXml();
}

// Those that are set. While the node runs, those that may change.
bridge::Parameters read(const ros::NodeHandle& self, bridge::Parameters parameters, bool runs) {
  const auto look = [&](const auto& field, bool is_fixed) {
    XmlRpc::XmlRpcValue value;
    if (bridge::is_of_dds(field.has) || (runs && is_fixed)) return;
    if (!self.getParamCached(field.name, value)) return;
    std::optional<double> number;
    if (value.getType() == value.TypeInt) number = static_cast<int>(value);
    if (value.getType() == value.TypeDouble) number = static_cast<double>(value);
    bridge::set(parameters, field.name, text_of(value), number);
  };
  XmlRpc::XmlRpcValue all;
  if (!runs && self.getParam(self.getNamespace(), all) && all.getType() == all.TypeStruct) {
    for (auto& [name, value] : all) {  // a struct: another node's, below this one's name
      if (value.getType() == value.TypeStruct || !bridge::is_foreign(name, text_of(value)))
        continue;
      ROS_INFO("ignored, not a parameter of this node: %s", name.c_str());
    }
  }
  for (const bridge::NumberField& field : bridge::kNumbers) look(field, field.is_fixed);
  for (const bridge::ChoiceField& field : bridge::kChoices) look(field, true);
  bridge::check(parameters);
  return parameters;
}

class Node {
 public:
  Node() {
    const bool is_array = parameters_.encoding == bridge::kDecoded;
    const bridge::Ros1Type& type = is_array ? bridge::kEventArray : bridge::kEventPacket;
    const auto queue = static_cast<std::uint32_t>(parameters_.queue);
    ros::AdvertiseOptions options("events", queue, type.md5, type.name, type.definition);
    packages_ = self_.advertise(options);
    stats_ = self_.advertise<String>("stats", 10);
    diagnostics_ = handle_.advertise<Diagnostics>("/diagnostics", 10);
    listen();
    using Event = ros::MessageEvent<const AnyMessage>;
    events_ = handle_.subscribe<AnyMessage, const Event&>(
        "events", queue, [this](const Event& event) { take(event); }, {},
        ros::TransportHints().tcpNoDelay());
    timer_ = self_.createWallTimer(ros::WallDuration(1.0),
                                   [this](const ros::WallTimerEvent&) { report(); });
  }
  ~Node() { session_.stop(); }  // delivers what waits

 private:
  void publish(const bridge::Message& message) {
    bridge::write_ros1(message, session_.frame_id(), bytes_.bytes);
    packages_.publish(bytes_);
  }

  void take(const ros::MessageEvent<const AnyMessage>& event) {
    bridge::Packet packet =
        bridge::read_ros1(event.getConnectionHeader()["md5sum"],
                          std::as_bytes(std::span(event.getMessage()->bytes)), decoded_);
    packet.publisher = event.getPublisherName();
    packet.waited_ns = (ros::Time::now() - event.getReceiptTime()).toNSec();
    session_.take(packet);
  }

  void listen() {
    if (parameters_.feedback == "topic") {
      using Time = ros::MessageEvent<const ProcessingTime>;
      times_ = self_.subscribe<ProcessingTime, const Time&>(
          "processing_time", 10, [this](const Time& time) {
            const auto& finished = *time.getMessage();
            relay_.feedback(time.getPublisherName(), finished.seq, finished.time);
          });
    }
    if (parameters_.feedback != "service") return;
    // Any sum is taken: the published node's consumers call without `seq`.
    using Call = ros::ServiceEvent<AnyMessage, Feedback::Response>;
    ros::AdvertiseServiceOptions options;
    options.init<Feedback>("feedback", {});
    options.md5sum = "*";
    options.helper = boost::make_shared<ros::ServiceCallbackHelperT<Call>>([this](Call& call) {
      namespace wire = ros::serialization;
      Feedback::Request request;
      AnyMessage bytes = call.getRequest();
      bytes.bytes.resize(wire::serializationLength(request));
      wire::IStream stream(bytes.bytes.data(), static_cast<std::uint32_t>(bytes.bytes.size()));
      wire::deserialize(stream, request);
      call.getResponse().success = relay_.feedback(call.getCallerName(), request.seq, request.time);
      return true;
    });
    service_ = self_.advertiseService(options);
  }

  bridge::Consumers consumers() const {
    const std::size_t heard = packages_.getNumSubscribers();
    return {.heard = heard, .answering = times_ ? times_.getNumPublishers() : heard};
  }

  // Heeds the parameters that may change; says once why it does not.
  void update() {
    std::string refusal;
    try {
      parameters_ = read(self_, parameters_, true);
      session_.set(parameters_);
    } catch (const std::invalid_argument& error) {
      refusal = std::string("parameters refused: ") + error.what();
    }
    if (!refusal.empty() && refusal != refusal_) ROS_WARN("%s", refusal.c_str());
    refusal_ = refusal;
  }

  void report() {
    update();
    const bridge::Session::Report report = session_.report(events_.getTopic());
    String json;
    json.data = bridge::to_json(report.facts).c_str();
    stats_.publish(json);
    Diagnostics array;
    array.header.stamp = ros::Time::now();
    bridge::write(report, ros::this_node::getName().c_str(), array.status.emplace_back());
    diagnostics_.publish(array);
  }

  ros::NodeHandle handle_, self_{"~"};
  bridge::Parameters parameters_ = read(self_, {.encoding = std::string(bridge::kDecoded)}, false);
  std::string refusal_;  // the one that was logged last
  AnyMessage bytes_;     // the session's thread's
  std::vector<asap::Event> decoded_;
  ros::Publisher packages_, stats_, diagnostics_;
  bridge::Relay relay_{parameters_, [this](const bridge::Message& message) { publish(message); },
                       [this] { return consumers(); }};
  bridge::Session session_{parameters_, relay_, say};
  ros::Subscriber events_, times_;
  ros::ServiceServer service_;
  ros::WallTimer timer_;
};

void run() {
  Node node;
  ros::XMLRPCManager::instance()->unbind("shutdown");
  ros::XMLRPCManager::instance()->bind("shutdown", end_by_call);
  is_ready = 1;
  while (is_over == 0 && ros::ok()) {
    ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(kLookEvery_s));
  }
}

}  // namespace
}  // namespace asap_ros

// 0 after SIGINT, SIGTERM or `rosnode kill`, 2 for bad parameters.
int main(int argc, char** argv) {
  ros::init(argc, argv, "asap", ros::init_options::NoSigintHandler);
  std::signal(SIGINT, asap_ros::end);
  std::signal(SIGTERM, asap_ros::end);
  int code = 0;
  ros::start();  // waits for the master; the end of run() would end the log otherwise
  try {
    if (asap_ros::is_over == 0) asap_ros::run();
  } catch (const std::exception& error) {
    ROS_FATAL("%s", error.what());
    code = 2;
  }
  ros::shutdown();
  return code;
}
