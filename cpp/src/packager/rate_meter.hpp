// RateMeter: events per second over the last window of time, robust against bursts on one
// timestamp, single events and long silences. The window [begin, newest) is half-open, so that a
// burst half seen does not count; it is at least 1 ms long and begins at the last mark before that,
// so there is always a time to divide by. O(1) amortised per observation, fixed memory.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace asap::inline v0_1 {

class RateMeter {
 public:
  // `count` more events have entered, from oldest_ns to newest_ns; time does not go back.
  void observe(std::size_t count, std::int64_t oldest_ns, std::int64_t newest_ns) noexcept;

  struct Window {
    std::uint64_t events;
    std::int64_t ns;  // > 0

    double per_second() const noexcept {
      return static_cast<double>(events) * 1e9 / static_cast<double>(ns);
    }
  };

  // What has entered lately. In the first millisecond: all that has entered, in one millisecond.
  Window window() const noexcept;
  double per_second() const noexcept { return window().per_second(); }

 private:
  struct Mark {
    std::int64_t time_ns;
    std::uint64_t before;  // events before this time
  };
  static constexpr std::int64_t kWindowNs = 1'000'000;
  static constexpr std::int64_t kMarkEveryNs = kWindowNs / 16;
  static constexpr std::size_t kMarks = 32;  // power of two, > kWindowNs / kMarkEveryNs + 1

  const Mark& mark(std::uint64_t i) const noexcept { return marks_[i % kMarks]; }

  std::array<Mark, kMarks> marks_{};
  std::uint64_t oldest_ = 0;  // marks [oldest_, end_) span the window
  std::uint64_t end_ = 0;
  Mark newest_{};
  std::uint64_t total_ = 0;
};

inline void RateMeter::observe(std::size_t count, std::int64_t oldest_ns,
                               std::int64_t newest_ns) noexcept {
  if (end_ == 0) {
    newest_ = {oldest_ns, 0};
    marks_[end_++] = newest_;
  }
  if (newest_ns > newest_.time_ns) {
    newest_ = {newest_ns, total_ + (oldest_ns < newest_ns ? count - 1 : 0)};
  }
  total_ += count;
  if (newest_ns - mark(end_ - 1).time_ns >= kMarkEveryNs) marks_[end_++ % kMarks] = newest_;
  while (oldest_ + 1 < end_ && newest_ns - mark(oldest_ + 1).time_ns >= kWindowNs) ++oldest_;
}

inline RateMeter::Window RateMeter::window() const noexcept {
  const std::int64_t elapsed_ns = newest_.time_ns - mark(oldest_).time_ns;
  if (end_ == 0 || elapsed_ns < kWindowNs) return {total_, kWindowNs};
  return {newest_.before - mark(oldest_).before, elapsed_ns};
}

}  // namespace asap::inline v0_1
