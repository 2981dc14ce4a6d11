// Stream: the source, packet by packet, with the faults of a source: rates that jump, silence and
// bursts, bad data. What an event holds depends on the seed and its number alone: the stream after
// the faults is the same without them, only its stamps are shifted.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "asap/core/event.hpp"
#include "faults.hpp"

namespace asap::simulation {

struct Packet {
  std::vector<Event> events;
  std::vector<std::uint32_t> numbers;  // of the source's events
  std::int64_t sent_ns = 0;            // of the stream's own time
};

class Stream {
 public:
  Stream(const Setup& setup, const std::vector<Fault>& faults);

  bool ended() const noexcept { return next_ == setup_.events; }
  // Events that have been sent.
  std::size_t position() const noexcept { return next_; }
  void read(Packet& packet);

 private:
  double gap_ns(std::size_t number) const noexcept;
  void spoil(const Fault& fault, Event& event, Packet& packet);

  const Setup& setup_;
  const std::vector<Fault>& faults_;
  CounterRandom random_;
  Draw draw_;
  std::size_t next_ = 0;
  std::int64_t time_ns_ = 0;
  std::int64_t shift_us_ = 0;
  std::int64_t last_us_ = 0;  // stamp of the event before
  std::int64_t stuck_us_ = 0;
  std::size_t stuck_ = 0;  // events that will still carry stuck_us_
};

}  // namespace asap::simulation
