// Node: all of the node but roscpp, whose headers do not compile as C++20. This header is C++17;
// the implementation is C++20 and holds the bridge and the pipeline. Messages are bytes on the
// wire.
//
// One thread but feedback(), which is any thread's. Outward: that thread's or the session's.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace asap_ros {

using Bytes = std::vector<std::uint8_t>;
using Value =
    std::variant<std::monostate, double, std::string>;  // of a parameter; or it is not set
using Values = std::function<Value(const std::string& name)>;

struct Outward {
  std::function<void(const Bytes& message)> publish;
  std::function<bool()> is_heard;  // a consumer is there
  std::function<void(bool is_trouble, const std::string& line)> say;
};

struct Type {
  std::string name;
  std::string md5;
  std::string definition;
};

struct Report {
  std::uint8_t level;  // of diagnostic_msgs
  std::string message;
  std::string hardware_id;
  std::string json;
  std::vector<std::pair<std::string, std::string>> facts;
};

class Node {
 public:
  // Throws std::invalid_argument for parameters that are none.
  Node(const Values& values, Outward outward);
  ~Node();  // stop()

  Type type() const;                                 // of the messages to publish
  std::uint32_t queue() const;                       // the parameter
  const std::string& feedback() const;               // the same
  bool feedback(std::uint64_t seq, double seconds);  // false: refused

  void take(const std::string& md5, const std::string& publisher, const Bytes& message);

  // Heeds the parameters that may change; says once why it does not.
  void update(const Values& values);

  Report report(const std::string& topic);

  // Delivers what waits, and ends. Says the ledger.
  void stop();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace asap_ros
