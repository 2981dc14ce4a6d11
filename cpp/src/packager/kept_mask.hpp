// KeptMask: what became of every received event of a recording, one bit for each: whether the
// algorithm got it. It leads results back to the arrays that the events came from. On request
// only: memory grows by three bits per event.
//
// Three parts of a run write their own bits, each in its own order, and read() puts them together
// when the run is over: the validator, of the events received; the intake, of those that passed it;
// the packager, of those that came to the ring.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "asap/core/event.hpp"
#include "asap/filter/validator.hpp"
#include "asap/packager/package.hpp"
#include "buffer/event_buffer.hpp"
#include "core/bit_log.hpp"

namespace asap::inline v0_1 {

class KeptMask {
 public:
  // Notes which events this validator, which the mask outlives, lets through.
  void follow(Validator& validator) noexcept { validator.passed_ = &passed_; }
  const BitLog& passed() const noexcept { return passed_; }

  // Producer: of these, `taken` came to the ring and `lost` found it full.
  void entered(std::size_t taken, std::size_t lost) {
    entered_.append(taken, true);
    entered_.append(lost, false);
  }

  // Consumer: the next calls need no allocation, for `events` events and a package.
  void make_room(std::size_t events);

  // Consumer: the next `count` events leave the ring undecided.
  void passed_over(std::size_t count) noexcept { delivered_.append(count, false); }

  // Consumer: the next `count` events leave the ring, these of `raw`, in order, as a package. None:
  // they count to the next package. Equal events are told apart by nothing: the first one counts.
  void packaged(const EventPieces& raw, std::size_t count, EventSpan kept) noexcept;

  // Once the run is over. What has not been decided, is not kept. None, if the filter in front has
  // changed events or their order, so that they are not found again.
  std::optional<KeptEvents> read() const;

 private:
  BitLog passed_;
  BitLog entered_;
  BitLog delivered_;
  std::vector<std::uint64_t> first_;  // of every package, counted in the ring
  bool is_lost_ = false;              // a kept event was none of those that came
  bool is_open_ = false;              // events wait for the next package with something kept
  std::uint64_t open_first_ = 0;
};

}  // namespace asap::inline v0_1
