#include "node.hpp"

#include <mutex>
#include <optional>
#include <span>
#include <stdexcept>

#include "asap/core/check.hpp"
#include "ros/bridge/relay.hpp"
#include "ros/bridge/ros1_messages.hpp"
#include "ros/bridge/session.hpp"

namespace asap_ros {
namespace {

namespace ros = asap::ros;

void read(ros::Parameters& parameters, const ros::NumberField& number, const Value& value) {
  if (const auto* text = std::get_if<std::string>(&value)) {
    asap::throw_bad_value(number.name, *text, "must be a number");
  }
  if (const auto* given = std::get_if<double>(&value)) parameters.*number.field = *given;
}

void read(ros::Parameters& parameters, const ros::ChoiceField& choice, const Value& value) {
  if (const auto* given = std::get_if<double>(&value)) {
    parameters.*choice.field = asap::to_text(*given);
  }
  if (const auto* text = std::get_if<std::string>(&value)) parameters.*choice.field = *text;
}

ros::Parameters parameters_at_the_start(const Values& values) {
  ros::Parameters parameters{.encoding = std::string(ros::kDecoded)};
  for (const ros::NumberField& number : ros::kNumbers) {
    read(parameters, number, values(number.name));
  }
  for (const ros::ChoiceField& choice : ros::kChoices) {
    read(parameters, choice, values(choice.name));
  }
  return parameters;
}

}  // namespace

struct Node::Parts {
  Parts(const Values& values, Outward out)
      : outward(std::move(out)),
        parameters(parameters_at_the_start(values)),
        relay(
            parameters, [this](const ros::Message& message) { publish(message); },
            outward.is_heard),
        session(parameters, relay, outward.say) {}

  void publish(const ros::Message& message) {
    {
      const std::lock_guard lock(frame);
      ros::write_ros1(message, frame_id, bytes);
    }
    outward.publish(bytes);
  }

  const Outward outward;
  ros::Parameters parameters;
  std::string refusal;  // of a parameter, said last
  ros::Ros1Reader reader;
  std::mutex frame;  // the next one
  std::string frame_id;
  Bytes bytes;  // the session's thread's
  ros::Relay relay;
  ros::Session session;  // the last member: its thread uses the others
};

Node::Node(const Values& values, Outward outward)
    : parts_(std::make_unique<Parts>(values, std::move(outward))) {}

Node::~Node() = default;

Type Node::type() const {
  const bool is_array = parts_->parameters.encoding == ros::kDecoded;
  const ros::Ros1Type& type = is_array ? ros::kEventArray : ros::kEventPacket;
  return {type.name, type.md5, type.definition};
}

const std::string& Node::feedback() const { return parts_->parameters.feedback; }

bool Node::feedback(double seconds) { return parts_->relay.feedback(seconds); }

std::string Node::take(const std::string& md5, const std::string& publisher, const Bytes& message) {
  auto [packet, stamp_ns, frame_id] = parts_->reader.read(md5, std::as_bytes(std::span(message)));
  packet.publisher = publisher;
  {
    const std::lock_guard lock(parts_->frame);
    if (!packet.is_torn) parts_->frame_id = frame_id;
  }
  const std::optional<ros::Refusal> refusal = parts_->session.take(packet, stamp_ns);
  return refusal ? ros::sentence(*refusal, packet) : "";
}

void Node::update(const Values& values) {
  ros::Parameters next = parts_->parameters;
  std::string refusal;
  try {
    for (const ros::NumberField& number : ros::kNumbers) read(next, number, values(number.name));
    ros::check(next);
    parts_->parameters = next;
    parts_->session.set_latency(next.latency_ms);
    parts_->relay.set(next);
  } catch (const std::invalid_argument& error) {
    refusal = std::string("parameters refused: ") + error.what();
  }
  if (!refusal.empty() && refusal != parts_->refusal) parts_->outward.say(refusal);
  parts_->refusal = refusal;
}

Report Node::report(const std::string& topic) {
  ros::Facts facts = parts_->session.facts();
  const ros::Facts more = parts_->relay.facts();
  facts.insert(facts.end(), more.begin(), more.end());
  return {ros::to_json(facts), parts_->session.trouble(topic), facts};
}

void Node::stop() { parts_->session.stop(); }

}  // namespace asap_ros
