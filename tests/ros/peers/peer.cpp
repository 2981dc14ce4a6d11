// What tests/ros starts beside the node, in C++:
//
//   peer source EVENTS MESSAGES PERIOD_US     a driver; ends when all are published
//   peer relay                                publishes each message again
//   peer sink TOPIC EVENTS [FINISHED_TOPIC]   a consumer; ends when so many have come, or after 3 s
//                                             without any more; gives feedback on the second topic
//   peer process asap|relay EVENTS MESSAGES PERIOD_US [DRIVERS]
//                                             drivers, component and consumer in one process
//   peer codec EVENTS MESSAGES                decodes and encodes without a middleware
//   peer virtual MESSAGES                     bridge and Simulator: the packages of virtual time
//
// Each prints one line of JSON at its end.
#include <atomic>
#include <chrono>
#include <class_loader/class_loader.hpp>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <exception>
#include <memory>
#include <new>
#include <rclcpp_components/node_factory.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "asap/runner/simulator.hpp"
#include "asap/schemes/deadline.hpp"
#include "nodes.hpp"
#include "ros/bridge/package_writer.hpp"

namespace {

using namespace std::chrono_literals;

// Copies of a message are allocations of the size of its bytes, which nothing else has.
std::atomic<std::size_t> watched_size = 0;
std::atomic<std::uint64_t> watched_allocations = 0;

}  // namespace

void* operator new(std::size_t size) {
  if (size == watched_size) ++watched_allocations;
  if (void* const memory = std::malloc(size == 0 ? 1 : size)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace asap_peers {
namespace {

using Words = std::vector<std::string>;
constexpr std::int64_t kPatience_us = 3'000'000;

Load load_of(const Words& words, std::size_t at) {
  return {std::stoul(words.at(at)), std::stoul(words.at(at + 1)), std::stol(words.at(at + 2))};
}

void say_arrivals(const Sink& sink) {
  std::printf(R"({"events": %llu, "p50_us": %lld, "p99_us": %lld, "max_us": %lld)",
              static_cast<unsigned long long>(sink.events()),
              static_cast<long long>(sink.quantile(.5)), static_cast<long long>(sink.quantile(.99)),
              static_cast<long long>(sink.quantile(1)));
}

// Until `events` have come, or none for a while after the first.
void spin_until(rclcpp::Executor& executor, const Sink& sink, std::uint64_t events) {
  std::uint64_t seen = 0;
  std::int64_t changed_us = now_us();
  while (rclcpp::ok() && sink.events() < events) {
    executor.spin_once(std::chrono::milliseconds(100));
    if (sink.events() != seen || seen == 0) changed_us = now_us();
    seen = sink.events();
    if (now_us() - changed_us > kPatience_us) break;
  }
}

void source(const Words& words) {
  const Load load = load_of(words, 1);
  const auto node = std::make_shared<Source>(load, 1, rclcpp::NodeOptions());
  rclcpp::executors::SingleThreadedExecutor executor;
  executor.add_node(node);
  while (rclcpp::ok() && node->seconds() == 0) executor.spin_once(std::chrono::milliseconds(100));
  std::this_thread::sleep_for(std::chrono::seconds(2));  // what is on the way is delivered
  std::printf("{\"events\": %zu, \"seconds\": %.3f}\n", load.events * load.messages,
              node->seconds());
}

void sink(const Words& words) {
  const std::string finished_topic = words.size() > 3 ? words[3] : "";
  const auto node = std::make_shared<Sink>(words.at(1), finished_topic, rclcpp::NodeOptions());
  rclcpp::executors::SingleThreadedExecutor executor;
  executor.add_node(node);
  spin_until(executor, *node, std::stoull(words.at(2)));
  say_arrivals(*node);
  std::puts("}");
}

void process(const Words& words) {
  const Load load = load_of(words, 2);
  const bool is_asap = words.at(1) == "asap";
  const auto options = rclcpp::NodeOptions().use_intra_process_comms(true);
  class_loader::ClassLoader loader("libasap_components.so");
  rclcpp_components::NodeInstanceWrapper component;
  std::shared_ptr<Relay> relay;
  rclcpp::executors::SingleThreadedExecutor executor;
  if (is_asap) {
    const std::string name = "rclcpp_components::NodeFactoryTemplate<asap_ros::PackageNode>";
    auto given = options;
    given.append_parameter_override("latency_ms", 100.0);
    component =
        loader.createInstance<rclcpp_components::NodeFactory>(name)->create_node_instance(given);
    executor.add_node(component.get_node_base_interface());
  } else {
    relay = std::make_shared<Relay>(options);
    executor.add_node(relay);
  }
  const auto consumer =
      std::make_shared<Sink>(is_asap ? "asap/events" : "relay/events", "", options);
  executor.add_node(consumer);
  watched_size = bytes_of(load.events);
  {
    std::vector<std::shared_ptr<Source>> drivers;
    for (int i = 0; i < (words.size() > 5 ? std::stoi(words[5]) : 1); ++i) {
      drivers.push_back(std::make_shared<Source>(load, 1, options));
      executor.add_node(drivers.back());
    }
    spin_until(executor, *consumer, load.events * load.messages);
  }
  watched_size = 0;
  say_arrivals(*consumer);
  std::printf(", \"messages\": %zu, \"allocations\": %llu}\n", load.messages,
              static_cast<unsigned long long>(watched_allocations.load()));
}

// Of this thread: what others do meanwhile does not count.
std::int64_t processor_ns() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return std::int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec;
}

void codec(const Words& words) {
  const std::size_t events = std::stoul(words.at(1)), messages = std::stoul(words.at(2));
  ros::PacketReader reader;
  ros::PackageWriter writer("evt3");
  std::vector<std::uint8_t> bytes;
  std::int64_t decode_ns = 0, encode_ns = 0;
  for (std::uint64_t i = 0; i < messages; ++i) {
    const auto packet = message(events, i, now_us());
    const ros::Packet fields = packet_of(*packet);
    const std::int64_t start_ns = processor_ns();
    std::vector<asap::Event> decoded;
    decoded.reserve(events);
    reader.see(fields);
    reader.decode(fields, [&](asap::EventSpan block) {
      decoded.insert(decoded.end(), block.begin(), block.end());
    });
    const std::int64_t middle_ns = processor_ns();
    writer.write(decoded, bytes);
    decode_ns += middle_ns - start_ns;
    encode_ns += processor_ns() - middle_ns;
  }
  const auto per_event = [&](std::int64_t ns) {
    return static_cast<double>(ns) / static_cast<double>(events * messages);
  };
  std::printf("{\"decode_ns\": %.2f, \"encode_ns\": %.2f}\n", per_event(decode_ns),
              per_event(encode_ns));
}

void virtual_time(const Words& words) {
  const std::uint64_t messages = std::stoull(words.at(1));
  asap::Deadline scheme;
  asap::Simulator simulator(scheme, asap::LinearCost{{.alpha_us = 100, .beta_ns = 3'000}},
                            {.latency = 10ms, .validator = {.width = 640, .height = 480}});
  ros::PacketReader reader;
  std::uint64_t seen = 0;
  const auto node = std::make_shared<rclcpp::Node>("simulator");
  const auto subscription = node->create_subscription<EventPacket>(
      "events", qos(), [&](EventPacket::ConstSharedPtr message) {
        const ros::Packet packet = packet_of(*message);
        if (!ros::refusal_of(packet)) {
          reader.see(packet);
          reader.decode(packet, [&](asap::EventSpan events) { simulator.feed(events); });
        }
        ++seen;
      });
  rclcpp::executors::SingleThreadedExecutor executor;
  executor.add_node(node);
  while (rclcpp::ok() && seen < messages) executor.spin_once(std::chrono::milliseconds(100));
  simulator.finish();
  const asap::RunLog& log = simulator.log();
  std::printf("[");
  for (std::size_t i = 0; i < log.size(); ++i) {
    const asap::PackageRow row = log[i];
    std::printf("%s[%.17g, %lld, %lld, %lld, %lld]", i == 0 ? "" : ", ", row.start_us,
                static_cast<long long>(row.t_first), static_cast<long long>(row.t_last),
                static_cast<long long>(row.offered), static_cast<long long>(row.size));
  }
  std::puts("]");
}

int run(int argc, char** argv) {
  const Words words = rclcpp::init_and_remove_ros_arguments(argc, argv);
  const Words given(words.begin() + 1, words.end());
  const std::string role = given.at(0);
  if (role == "source") source(given);
  if (role == "relay") rclcpp::spin(std::make_shared<Relay>(rclcpp::NodeOptions()));
  if (role == "sink") sink(given);
  if (role == "process") process(given);
  if (role == "codec") codec(given);
  if (role == "virtual") virtual_time(given);
  rclcpp::shutdown();
  return 0;
}

}  // namespace
}  // namespace asap_peers

int main(int argc, char** argv) {
  try {
    return asap_peers::run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "peer: %s\n", error.what());
    return 2;
  }
}
