// LiveLife: a Pipeline from its first push to its last package, on a machine of virtual time. The
// pipeline is the library's own, to the last instruction; only what it asks of the operating system
// is answered here. One thread: the consumer runs, and while it works, sleeps or looks at the clock
// the world goes on: the producer pushes, and others flush, set another bound, look and stop. The
// seed decides. (The order of memory is for Relacy, tests/model.)
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

#include "asap/runner/pipeline.hpp"
#include "live_setup.hpp"
#include "live_shadow.hpp"
#include "machine.hpp"
#include "reference_door.hpp"
#include "watched_scheme.hpp"
#include "world.hpp"

namespace asap::simulation {

class LiveLife final : private SchemeWatcher, private Machine {
 public:
  LiveLife(const Setup& setup, const LiveSetup& live, Scheme& scheme, World& world);

  // From start to stop; again, and again, where the seed restarts the same pipeline.
  void run();

 private:
  // Machine
  Time now() noexcept override;
  void sleep(System::Word& word, Time deadline) noexcept override;
  void wake(System::Word& word) noexcept override;

  // Watcher
  void asked(const Backlog& backlog) noexcept override;
  void decided(const Backlog& backlog, const Decision& decision) noexcept override;
  void told(const Outcome& outcome) noexcept override;

  // World
  std::int64_t next_ns() const noexcept { return std::min(packet_ns_, ask_ns_); }
  void run_until(std::int64_t time_ns);
  void act();
  void produce();
  void push();
  void read_packet();
  void ask();
  void stop(bool drain);
  void give_up() noexcept;
  void hold_now();

  // Consumer
  void live_once();
  void loop();
  void work(const Package& package);
  [[noreturn]] void fail();
  std::size_t filter(EventSpan events, std::span<Event> out);

  const Setup& setup_;
  const LiveSetup& live_;
  World& world_;
  Journal& journal_;
  Draw& draw_;
  const bool own_loop_;
  const Scheme& own_scheme_;
  WatchedScheme scheme_;
  std::int64_t bound_ns_;

  std::int64_t time_ns_ = 0;
  bool in_world_ = false;
  bool has_given_up_ = false;

  std::optional<ReferenceDoor> door_;
  std::optional<LiveShadow> shadow_;
  std::int64_t offset_ns_ = 0;  // machine's time less the stream's own
  std::int64_t packet_ns_ = kNever;
  std::int64_t ask_ns_ = kNever;
  bool is_stopped_ = false;
  Packet packet_;
  std::vector<Event> good_;
  std::vector<std::uint32_t> numbers_;

  Pipeline pipeline_;  // the last: it looks at the clock
};

}  // namespace asap::simulation
