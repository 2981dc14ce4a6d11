// Thinner: makes the events of a package of raw ones: those that pass the filter in front, if there
// is one, and the gamma filter, contiguous and in order; and notes when they arrived. Where every
// raw event is kept and the ring does not wrap, they are a slice of the ring, without a copy; other
// packages are copied and may be bounded: what would not fit is left undecided, for the next one.
//
// Called on the consumer's thread. O(1) per event, no allocation after construction. Throws what
// the filter in front throws: then the package is lost, its raw events are still in the ring.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>

#include "asap/filter/gamma_filter.hpp"
#include "asap/packager/package.hpp"
#include "buffer/event_buffer.hpp"
#include "packager/event_times.hpp"

namespace asap::inline v0_1 {

// Which share of raw events is wanted, by chance or, where nothing follows that could make up for
// the chance in their number, exactly.
struct Share {
  double gamma = 1.0;
  bool exactly = false;
};

class Thinner {
 public:
  // `times` outlives the thinner. A package has at most `capacity` raw events, and at most
  // `max_copied` kept ones unless it is a slice of the ring.
  Thinner(const EventTimes& times, std::size_t capacity, std::uint64_t seed, FrontFilter before,
          std::size_t max_copied = std::numeric_limits<std::size_t>::max());

  // What a thinner takes from the heap if times are arrivals, in a table of so many steps.
  static std::size_t memory_bytes(std::size_t capacity, std::size_t max_copied, std::size_t steps,
                                  bool is_filtered) noexcept;

  // Writes to all memory, so that no page of it is missing later. Before the first package.
  void prefault() noexcept;

  // Begins with the first event of a run, with this filter in front as it is now.
  void reset(std::uint64_t seed, const FrontFilter& before) {
    before_ = before;
    gamma_ = GammaFilter(seed);
  }

  // A new package of these waiting events, the first of which lies at ring index `head`.
  void begin(const EventPieces& raw, std::uint64_t head) noexcept {
    raw_ = raw;
    head_ = head;
    events_ = {};
    filtered_ = 0;
    decided_ = 0;
    kept_times_.clear();
  }

  // Decides the raw events [begin, end), which follow those before, and returns the kept ones. With
  // a filter in front the share is still that of the raw events, as far as enough of them pass.
  // Where the package is full it ends before: see decided().
  EventSpan decide(std::size_t begin, std::size_t end, Share share) {
    const bool is_whole = share.gamma >= 1.0 && begin == 0 && end <= raw_.first.size();
    if (is_whole && !before_) return take_slice(raw_.first.first(end), 0);
    return decide_part(begin, end, share);
  }

  // The raw events of the package, and more if it ends early.
  const EventPieces& raw() const noexcept { return raw_; }

  // Raw events of the package that are decided.
  std::size_t decided() const noexcept { return decided_; }

  // The package so far: its events, and how many the filter in front has dropped.
  EventSpan events() const noexcept { return events_; }
  std::size_t filtered() const noexcept { return filtered_; }
  // When its events arrived; only for times by arrival.
  const KeptTimes& arrivals() const noexcept { return kept_times_; }

  // Passes over events that leave the stream undecided.
  void skip(std::size_t count) noexcept { gamma_.skip(count); }

 private:
  // The consumer owns the slots until they are consumed.
  EventSpan take_slice(EventSpan slice, std::size_t begin) noexcept {
    gamma_.skip(slice.size());
    const std::size_t size = events_.size();
    events_ = {size == 0 ? slice.data() : events_.data(), size + slice.size()};
    decided_ = begin + slice.size();
    if (times_.by_arrival()) note_arrivals(begin, size);
    return slice;
  }
  void note_arrivals(std::size_t begin, std::size_t size) noexcept;
  EventSpan decide_part(std::size_t begin, std::size_t end, Share share);
  EventSpan thin(std::size_t begin, std::size_t end, Share share) noexcept;
  EventSpan filter_and_thin(std::size_t begin, std::size_t end, Share share);
  KeepThreshold threshold(std::size_t events, Share share) const noexcept;
  bool fits(std::size_t more) const noexcept { return events_.size() + more <= max_copied_; }
  bool is_slice() const noexcept { return !events_.empty() && events_.data() != kept_.get(); }
  void leave_the_ring() noexcept;
  std::span<Event> room_from(std::size_t size) const noexcept {
    return {kept_.get() + size, max_copied_ - size};
  }

  const EventTimes& times_;
  FrontFilter before_;
  GammaFilter gamma_;
  const std::size_t max_copied_;
  const std::size_t max_numbers_;
  const std::unique_ptr<Event[]> kept_;             // the package, unless it is a slice of the ring
  const std::unique_ptr<std::uint64_t[]> numbers_;  // scratch: the random numbers of a share

  EventPieces raw_{};
  std::uint64_t head_ = 0;
  EventSpan events_{};
  std::size_t filtered_ = 0;
  std::size_t decided_ = 0;
  KeptTimes kept_times_;
  KeptTimes passed_times_;  // of the events behind the filter in front
};

}  // namespace asap::inline v0_1
