// BackgroundActivityFilter: drops events without support. An event passes if one of its eight
// neighbours, of either polarity, fired at most window_us before it; its own pixel does not count.
// A rejected event still supports others. One thread. O(1) per event, no allocation
// after construction. Belongs in front of the gamma filter, which would remove the support.
// Source: Delbruck, "Frame-free dynamic digital vision", 2008.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "asap/core/event.hpp"

namespace asap {

struct BackgroundActivityFilterConfig {
  int width;                      // px
  int height;                     // px
  std::int64_t window_us = 5000;  // 1 000 to 10 000 is usual
};

class BackgroundActivityFilter {
 public:
  using Config = BackgroundActivityFilterConfig;

  // Throws std::invalid_argument that names the bad field.
  explicit BackgroundActivityFilter(const Config& config);
  ~BackgroundActivityFilter();
  BackgroundActivityFilter(const BackgroundActivityFilter& other);
  BackgroundActivityFilter& operator=(const BackgroundActivityFilter& other);
  BackgroundActivityFilter(BackgroundActivityFilter&& other) noexcept;
  BackgroundActivityFilter& operator=(BackgroundActivityFilter&& other) noexcept;

  // Writes the events that pass to `out`, which holds at least events.size() (the tail beyond them
  // is scratch) and may be the events' own memory. Returns how many passed. Events outside the
  // frame do not pass and are counted.
  std::size_t process(EventSpan events, Event* out) noexcept;

  // The fraction of the events that reaches the filter, in [0, 1]: neighbours become as rare, so
  // the window grows to window_us / gamma, at most 500 s.
  void set_keep(double gamma);

  // Back to the state after construction.
  void reset() noexcept;

  // Events dropped because they lie outside the frame.
  std::uint64_t rejected() const noexcept;

  const Config& config() const noexcept;

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace asap
