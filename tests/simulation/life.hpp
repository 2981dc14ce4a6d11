// Life: one run of the library's own parts, put together as Pipeline, Replay and ConsumerLoop do,
// from the first event to the end or to a stop. Producer and consumer are two actors with a time of
// their own, in one thread: the one whose time is due acts, and inside an action, wherever another
// thread could get in between (behind a look at the clock, between note and push, push and slots,
// while the scheme thinks), the other one may act as well. The seed decides.
#pragma once

#include <cstdint>
#include <vector>

#include "asap/telemetry/ledger.hpp"
#include "buffer/age_slots.hpp"
#include "buffer/arrival_times.hpp"
#include "journal.hpp"
#include "packager/packager.hpp"
#include "reference_door.hpp"
#include "shadow.hpp"
#include "telemetry/telemetry.hpp"
#include "watched_scheme.hpp"
#include "world.hpp"

namespace asap::simulation {

class Life final : private SchemeWatcher {
 public:
  Life(const Setup& setup, Scheme& scheme, World& world);

  void run();

 private:
  enum class Doing { sleeps, works, gone, ended };
  enum class Source { packets, waits_to_push, closed };

  // Watcher
  void asked(const Backlog& backlog) noexcept override;
  void decided(const Backlog& backlog, const Decision& decision) noexcept override;
  void told(const Outcome& outcome) noexcept override;

  // Faults
  std::int64_t clock_ns() noexcept;  // the consumer's look at the clock

  // Producer
  void produce();
  void read_packet();
  void take_in(EventSpan good);
  void begin(const Event& first);
  void push(EventSpan events, const std::uint32_t* numbers);
  void push_arrived();
  void close();
  void stop(bool drain) noexcept;
  void let_producer(std::int64_t until_ns);

  // Consumer
  void consume();
  void ask();
  void sleep(std::uint64_t tail, std::int64_t until_ns) noexcept;
  void wake(std::int64_t time_ns) noexcept;
  void begin_package();
  void go_on();
  void complete(std::int64_t end_ns);
  void let_consumer(std::int64_t until_ns);

  Ledger ledger() const noexcept;
  void hold_between_steps();

  const Setup& setup_;
  World& world_;
  Journal& journal_;
  Draw& draw_;
  Shadow shadow_;
  ReferenceDoor reference_door_;
  WatchedScheme scheme_;

  Validator door_;
  Telemetry telemetry_;
  EventBuffer buffer_;
  AgeSlots ages_;
  ArrivalTimes arrivals_;
  Packager packager_;
  TimeAxis axis_;

  // Producer. Times are run time, from begin() on.
  Source source_ = Source::packets;
  bool in_producer_ = false;
  std::int64_t producer_ns_ = 0;
  std::int64_t offset_ns_ = 0;  // run time less the stream's own
  std::int64_t arrival_ns_ = 0;
  bool has_begun_ = false;
  Packet packet_;
  std::vector<Event> good_;  // what the reference door lets in of the packet
  std::vector<std::uint32_t> numbers_;
  std::size_t taken_in_ = 0;   // of them
  std::vector<Event> outbox_;  // by stamp: have passed the door, have not arrived
  std::vector<std::uint32_t> outbox_numbers_;
  std::size_t sent_ = 0;
  bool stop_wanted_ = false;
  bool drains_ = true;
  std::uint64_t flush_wanted_ = 0;

  // Consumer
  Doing doing_ = Doing::sleeps;
  bool in_consumer_ = false;
  std::int64_t consumer_ns_ = kNever;
  std::uint64_t wanted_tail_ = 1;
  bool abandoned_ = false;
  bool looks_first_ = false;  // asks only when an event is there, like ConsumerLoop
  Package package_;
};

}  // namespace asap::simulation
