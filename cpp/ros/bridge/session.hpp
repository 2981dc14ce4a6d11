// Session: the run of a node. Messages of one camera go in; packages of their events go to a
// receiver, within the latency bound, on a thread of the session. Another publisher is heard once
// the one before has been silent for a second: as a new epoch of its clock or, with a sensor of
// another size and from its second message on, in a run of its own. An event's age counts from when
// the middleware received its message.
//
// Any thread. take() decodes and pushes: O(bytes), never blocked by the receiver but where a run
// ends, which waits for the package in work.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <thread>

#include "asap/runner/pipeline.hpp"
#include "ros/bridge/attended.hpp"
#include "ros/bridge/facts.hpp"
#include "ros/bridge/packet_reader.hpp"
#include "ros/bridge/parameters.hpp"

namespace asap::ros {

enum class Level : std::uint8_t { ok, warn, error };  // as in diagnostic_msgs

struct Complaint {
  Level level = Level::ok;
  std::string message{};  // empty: none
};

// What a session works for.
class Receiver {
 public:
  virtual ~Receiver() = default;

  virtual Execution execution() const noexcept { return Execution::whole; }
  // A run begins: events of a sensor of this size will come.
  virtual void begin(const Geometry&) {}
  // On the session's thread, before the package in whose time it lies. Returns whether the
  // receiver passes it on.
  virtual bool trigger(const Trigger&) { return false; }
  // On the session's thread. `stamp_ns`: when the package began, by the clock of the messages.
  virtual void process(const Package& package, std::int64_t stamp_ns) = 0;
  // The run ends: a process() that waits for something waits no longer. Any thread.
  virtual void hurry() noexcept {}
  // The consumer of what it makes is there; it stays away. Any thread.
  virtual bool is_heard() const { return true; }
  virtual bool stalled() const { return false; }
  // What limits where not all is processed in time.
  virtual const char* bottleneck() const { return "the algorithm"; }
  // Reports what went wrong with the consumer since the last call; called once a second.
  virtual Complaint complaint() { return {}; }
  // Returns further facts for a report. Any thread.
  virtual Facts facts() const { return {}; }
  // Takes the parameters that may change while it runs. Any thread.
  virtual void set(const Parameters&) {}
};

class Session {
 public:
  using Say = std::function<void(Level, const std::string&)>;
  using NameOf = std::function<std::string(std::string_view publisher)>;

  struct Report {
    Level level = Level::ok;
    std::string message = "ok";
    std::string frame_id{};  // the camera's
    Facts facts{};           // the run, the time since the last report, the messages in all
  };

  // The receiver outlives the session. `say` gets a line where a run begins or ends and, once a
  // second at most, where a message is refused; `name_of` names a publisher for it. Throws
  // std::invalid_argument for parameters that are none.
  Session(
      const Parameters& parameters, Receiver& receiver, Say say,
      NameOf name_of = [](std::string_view publisher) { return std::string(publisher); });
  ~Session();  // stop()

  // The reason, if the message is refused; refused after stop() without one.
  std::optional<Refusal> take(const Packet& packet);

  // Takes the parameters that may change while it runs. Throws std::invalid_argument for bad ones.
  void set(const Parameters& parameters);

  // Delivers what waits, and ends. Says the ledger.
  void stop();

  // Once a second. `topic`: of the messages; `mismatch`: an end whose QoS does not match, or empty.
  Report report(const std::string& topic = "", const std::string& mismatch = "");
  PipelineStats stats() const;
  std::string frame_id() const;  // the camera's

 private:
  using Clock = std::chrono::steady_clock;

  // The stamp of a message and of its first event.
  struct Mark {
    std::int64_t t_us = 0;
    std::int64_t stamp_ns = 0;
  };

  // The camera that was refused last; it may be heard next.
  struct Other {
    std::string publisher;
    std::string frame_id;
    Geometry sensor;
    Clock::time_point at{};
  };

  using Counts = std::map<std::string, std::uint64_t>;

  std::optional<Refusal> refusal_of(const Packet& packet, Clock::time_point now) const;
  bool is_next(const Packet& packet, Clock::time_point now) const;
  std::string named(const std::string& publisher, const std::string& frame_id) const;
  void refuse(Refusal refusal, const Packet& packet, Clock::time_point now);
  void begin(const Geometry& sensor);
  void end();
  void mark(const Packet& packet, std::int64_t t_us);
  void note(std::span<const Trigger> triggers);
  void note_wait(const Packet& packet, Clock::time_point now);
  void process(const Package& package);
  void pass_triggers(std::int64_t until_us);
  void fail(const std::string& what);
  Counts counts_of(const PipelineStats& stats) const;
  void judge(Report& report, const Counts& since, const PipelineStats& stats,
             const std::string& topic, const std::string& late) const;
  std::string silence(const std::string& topic) const;
  std::string rejection(const Counts& since) const;
  std::string lateness(const Counts& since, const PipelineStats& stats) const;
  std::string missing(const Counts& since) const;
  std::int64_t stamp_of(std::int64_t t_us);
  Facts facts(const PipelineStats& stats) const;

  Receiver& receiver_;
  const Say say_;
  const NameOf name_of_;
  mutable std::mutex control_;
  DeadlineConfig scheme_config_;  // of the next run
  RunConfig run_config_;          // the same
  bool stopped_ = false;
  Geometry sensor_;
  PacketReader reader_;
  bool is_new_epoch_ = false;                // begins with the next event
  const std::size_t queue_;                  // messages that the middleware holds for us
  Clock::time_point heard_{};                // the camera
  Clock::time_point newest_ = Clock::now();  // message, whatever came of it
  Clock::time_point taken_{};                // when the last message had been taken
  Clock::time_point complained_{};
  Other other_;
  bool is_other_ = false;        // was refused since the last report
  std::string refusal_;          // of the last message that was refused
  std::int64_t waited_ns_ = 0;   // the longest since the last report
  std::size_t backlog_ = 0;      // messages in a row that waited for the one before
  std::size_t max_backlog_ = 0;  // since the last report
  bool is_behind_ = false;       // at the last report
  std::uint64_t messages_ = 0;
  std::array<std::uint64_t, kRefusals.size()> refused_{};
  Counts reported_;               // up to the last report
  LatencyHistogram latency_;      // likewise
  mutable std::mutex worker_;     // the next seven, which the worker reads and writes as well
  std::deque<Mark> marks_;        // one per message that may still wait
  std::deque<Trigger> triggers_;  // that wait for the events of their time
  std::uint64_t passed_ = 0;      // triggers
  bool is_trigger_loss_said_ = false;
  std::string frame_id_;
  std::uint64_t failures_ = 0;
  std::string failure_;
  std::optional<Attended> scheme_;
  std::unique_ptr<Pipeline> pipeline_;
  std::jthread thread_;  // runs the pipeline; uses all the others
};

// Fills a DiagnosticStatus of either middleware.
template <class Status>
void write(const Session::Report& report, const char* name, Status& status) {
  status.name = name;
  status.hardware_id = report.frame_id.c_str();
  status.level = static_cast<decltype(status.level)>(report.level);
  status.message = report.message.c_str();
  for (const Fact& fact : report.facts) {
    auto& entry = status.values.emplace_back();
    entry.key = fact.name.c_str();
    entry.value = fact.value.c_str();
  }
}

}  // namespace asap::ros
