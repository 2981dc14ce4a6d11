#include "node.hpp"

#include <span>
#include <stdexcept>
#include <string_view>

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

ros::Parameters parameters_at_the_start(const Values& values) {
  ros::Parameters parameters{.encoding = std::string(ros::kDecoded)};
  for (const ros::NumberField& number : ros::kNumbers) {
    read(parameters, number, values(number.name));
  }
  for (const ros::ChoiceField& choice : ros::kChoices) {
    const Value value = ros::is_of_dds(choice.has) ? Value{} : values(choice.name);
    if (const auto* given = std::get_if<double>(&value)) {
      parameters.*choice.field = asap::to_text(*given);
    }
    if (const auto* text = std::get_if<std::string>(&value)) parameters.*choice.field = *text;
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
        session(
            parameters, relay,
            [this](ros::Level level, const std::string& line) {
              outward.say(level != ros::Level::ok, line);
            },
            [](std::string_view publisher) { return std::string(publisher); }) {}

  void publish(const ros::Message& message) {
    ros::write_ros1(message, session.frame_id(), bytes);
    outward.publish(bytes);
  }

  const Outward outward;
  ros::Parameters parameters;
  std::string refusal;  // of a parameter, said last
  ros::Ros1Reader reader;
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

std::uint32_t Node::queue() const { return static_cast<std::uint32_t>(parts_->parameters.queue); }

const std::string& Node::feedback() const { return parts_->parameters.feedback; }

bool Node::feedback(std::uint64_t seq, double seconds) {
  return parts_->relay.feedback(seq, seconds);
}

void Node::take(const std::string& md5, const std::string& publisher, const Bytes& message) {
  ros::Packet packet = parts_->reader.read(md5, std::as_bytes(std::span(message)));
  packet.publisher = publisher;
  parts_->session.take(packet);
}

void Node::update(const Values& values) {
  ros::Parameters next = parts_->parameters;
  std::string refusal;
  try {
    for (const ros::NumberField& number : ros::kNumbers) {
      if (!number.is_fixed) read(next, number, values(number.name));
    }
    ros::check(next);
    parts_->parameters = next;
    parts_->session.set_latency(next.latency_ms);
    parts_->relay.set(next);
  } catch (const std::invalid_argument& error) {
    refusal = std::string("parameters refused: ") + error.what();
  }
  if (!refusal.empty() && refusal != parts_->refusal) parts_->outward.say(true, refusal);
  parts_->refusal = refusal;
}

Report Node::report(const std::string& topic) {
  ros::Session::Report report =
      parts_->session.report({.topic = topic, .is_heard = parts_->outward.is_heard()});
  const ros::Facts more = parts_->relay.facts();
  report.facts.insert(report.facts.end(), more.begin(), more.end());
  Report told{static_cast<std::uint8_t>(report.level),
              report.message,
              parts_->session.frame_id(),
              ros::to_json(report.facts),
              {}};
  for (const ros::Fact& fact : report.facts) told.facts.emplace_back(fact.name, fact.value);
  return told;
}

void Node::stop() { parts_->session.stop(); }

}  // namespace asap_ros
