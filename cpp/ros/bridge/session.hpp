// Session: the run of a node. Messages go in; packages of their events go to a receiver, within the
// latency bound, on a thread of the session. A sensor of another size begins a run of its own.
//
// Any thread. take() decodes and pushes: O(bytes), never blocked by the receiver but where a run
// ends, which waits for the package in work.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>

#include "asap/runner/pipeline.hpp"
#include "asap/schemes/deadline.hpp"
#include "ros/bridge/facts.hpp"
#include "ros/bridge/packet_reader.hpp"
#include "ros/bridge/parameters.hpp"

namespace asap::ros {

// What a session works for.
class Receiver {
 public:
  virtual ~Receiver() = default;

  virtual Execution execution() const noexcept { return Execution::whole; }
  // A run begins: events of a sensor of this size will come.
  virtual void begin(const Geometry&) {}
  // On the session's thread. `stamp_ns`: that of the message in which the package began.
  virtual void process(const Package& package, std::int64_t stamp_ns) = 0;
  // The run ends: a process() that waits for something waits no longer. Any thread.
  virtual void hurry() noexcept {}
  // What it works for stays away. Any thread.
  virtual bool stalled() const { return false; }
};

class Session {
 public:
  using Say = std::function<void(const std::string&)>;

  // The receiver outlives the session. `say` gets a line where a run begins or ends. Throws
  // std::invalid_argument for parameters that are none.
  Session(const Parameters& parameters, Receiver& receiver, Say say);
  ~Session();  // stop()

  // The reason, if the message is refused; refused after stop() without one.
  std::optional<Refusal> take(const Packet& packet, std::int64_t stamp_ns);

  // Throws std::invalid_argument for a bound out of range.
  void set_latency(double latency_ms);

  // Delivers what waits, and ends. Says the ledger.
  void stop();

  // Figures of the run, and the messages refused since the session began.
  Facts facts() const;

  // What went wrong since the last call, in a sentence; empty: nothing. `topic`: of the messages.
  std::string trouble(std::string_view topic);
  PipelineStats stats() const;

 private:
  // The stamp of a message and of its first event.
  struct Mark {
    std::int64_t stamp_ns = 0;
    std::int64_t t_us = 0;
  };

  void begin(const Geometry& sensor);
  void end();
  void process(const Package& package);
  std::int64_t stamp_of(std::int64_t t_us) const;

  Receiver& receiver_;
  const Say say_;
  mutable std::mutex control_;
  DeadlineConfig scheme_config_;  // of the next run
  bool stopped_ = false;
  Geometry sensor_;
  PacketReader reader_;
  std::uint64_t messages_ = 0;
  std::array<std::uint64_t, kRefusals.size()> refused_{};
  std::array<std::uint64_t, 3> told_{};  // by trouble(): overflow, lost, refused
  mutable std::mutex worker_;  // the next three, which the worker reads and writes as well
  Mark mark_;
  std::uint64_t failures_ = 0;
  std::string failure_;
  std::optional<Deadline> scheme_;
  std::unique_ptr<Pipeline> pipeline_;
  std::jthread thread_;  // runs the pipeline; uses all the others
};

}  // namespace asap::ros
