// The node as roscpp sees it: topics, a service, parameters and signals around a Node.
#include <asap_ros/Feedback.h>
#include <asap_ros/ProcessingTime.h>
#include <diagnostic_msgs/DiagnosticArray.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <ros/xmlrpc_manager.h>
#include <std_msgs/String.h>

#include <csignal>

#include "any_message.hpp"
#include "node.hpp"

namespace asap_ros {
namespace {

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

Value value_of(const ros::NodeHandle& handle, const std::string& name) {
  XmlRpc::XmlRpcValue value;
  if (!handle.getParamCached(name, value)) return {};
  switch (value.getType()) {
    case XmlRpc::XmlRpcValue::TypeInt:
      return static_cast<double>(static_cast<int>(value));
    case XmlRpc::XmlRpcValue::TypeDouble:
      return static_cast<double>(value);
    case XmlRpc::XmlRpcValue::TypeString:
      return static_cast<std::string>(value);
    default:
      return value.toXml();
  }
}

diagnostic_msgs::DiagnosticArray diagnostics_of(const Report& report) {
  diagnostic_msgs::DiagnosticStatus status;
  status.name = ros::this_node::getName();
  status.hardware_id = report.hardware_id;
  status.level = static_cast<std::int8_t>(report.level);
  status.message = report.message;
  for (const auto& [name, value] : report.facts) {
    status.values.emplace_back();
    status.values.back().key = name;
    status.values.back().value = value;
  }
  diagnostic_msgs::DiagnosticArray array;
  array.header.stamp = ros::Time::now();
  array.status.push_back(status);
  return array;
}

void run() {
  ros::NodeHandle handle, self("~");
  const Values values = [&](const std::string& name) { return value_of(self, name); };
  ros::Publisher packages;
  Node node(values, {[&](const Bytes& message) { packages.publish(AnyMessage{message}); },
                     [&] { return packages.getNumSubscribers() > 0; },
                     [](bool is_trouble, const std::string& line) {
                       if (is_trouble) ROS_WARN("%s", line.c_str());
                       if (!is_trouble) ROS_INFO("%s", line.c_str());
                     }});
  const Type type = node.type();
  ros::AdvertiseOptions options("events", node.queue(), type.md5, type.name, type.definition);
  packages = self.advertise(options);
  ros::Publisher stats = self.advertise<std_msgs::String>("stats", 10);
  ros::Publisher diagnostics =
      handle.advertise<diagnostic_msgs::DiagnosticArray>("/diagnostics", 10);

  ros::Subscriber times;
  ros::ServiceServer service;
  if (node.feedback() == "topic") {
    times = self.subscribe<ProcessingTime>(
        "processing_time", 10, [&](const auto& time) { node.feedback(time->seq, time->time); });
  }
  if (node.feedback() == "service") {
    // Whatever its sum: the published node's consumers call without `seq`.
    using Any = ros::ServiceSpec<AnyMessage, Feedback::Response>;
    ros::AdvertiseServiceOptions options;
    options.init<Feedback>("feedback", {});
    options.md5sum = "*";
    options.helper = boost::make_shared<ros::ServiceCallbackHelperT<Any>>(
        [&](AnyMessage& bytes, Feedback::Response& response) {
          namespace wire = ros::serialization;
          Feedback::Request request;
          bytes.bytes.resize(wire::serializationLength(request));
          wire::IStream stream(bytes.bytes.data(), static_cast<std::uint32_t>(bytes.bytes.size()));
          wire::deserialize(stream, request);
          response.success = node.feedback(request.seq, request.time);
          return true;
        });
    service = self.advertiseService(options);
  }

  using Event = ros::MessageEvent<const AnyMessage>;
  const ros::Subscriber events = handle.subscribe<AnyMessage, const Event&>(
      "events", node.queue(),
      [&](const Event& event) {
        node.take(event.getConnectionHeader()["md5sum"], event.getPublisherName(),
                  event.getMessage()->bytes);
      },
      {}, ros::TransportHints().tcpNoDelay());

  const ros::WallTimer timer =
      self.createWallTimer(ros::WallDuration(1.0), [&](const ros::WallTimerEvent&) {
        node.update(values);
        const Report report = node.report(events.getTopic());
        std_msgs::String json;
        json.data = report.json;
        stats.publish(json);
        diagnostics.publish(diagnostics_of(report));
      });

  ros::XMLRPCManager::instance()->unbind("shutdown");
  ros::XMLRPCManager::instance()->bind("shutdown", end_by_call);
  is_ready = 1;
  while (is_over == 0 && ros::ok()) {
    ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(kLookEvery_s));
  }
  node.stop();
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
