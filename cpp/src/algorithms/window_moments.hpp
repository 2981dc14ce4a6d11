// WindowMoments: count and first and second moments in x, y and t of a changing set of events,
// exact for ever: integer sums, added when an event enters, subtracted when it leaves, no drift, no
// scan. The sums are kept modulo 2^64, so raw sums may overflow (they do, with timestamps in Unix
// time); what is read is formed about the mean, and is right whenever the value about the mean
// fits. So no timestamp offset per cluster is kept or rebased, and two sets merge by plain
// addition. O(1), no allocation.
#pragma once

#include <cstdint>

#include "algorithms/event_window.hpp"

namespace asap::inline v0_1 {

struct Vector2 {
  double x;
  double y;
};

struct Covariance {
  double xx;
  double xy;
  double yy;
};

class WindowMoments {
 public:
  std::uint64_t count() const noexcept { return n_; }

  void add(std::uint64_t x, std::uint64_t y, std::int64_t stamp) noexcept {
    const auto t = static_cast<std::uint64_t>(stamp);
    n_ += 1;
    x_ += x;
    y_ += y;
    t_ += t;
    xx_ += x * x;
    xy_ += x * y;
    yy_ += y * y;
    tt_ += t * t;
    xt_ += x * t;
    yt_ += y * t;
  }

  void remove(std::uint64_t x, std::uint64_t y, std::int64_t stamp) noexcept {
    const auto t = static_cast<std::uint64_t>(stamp);
    n_ -= 1;
    x_ -= x;
    y_ -= y;
    t_ -= t;
    xx_ -= x * x;
    xy_ -= x * y;
    yy_ -= y * y;
    tt_ -= t * t;
    xt_ -= x * t;
    yt_ -= y * t;
  }

  WindowMoments& operator+=(const WindowMoments& other) noexcept;

  // All three: precondition count() > 0.
  Vector2 centroid() const noexcept;       // px
  Covariance covariance() const noexcept;  // px^2, of the events themselves (divided by n)

  // Slope of the regression of x and y on t, px/us; 0 if all timestamps are equal. `near` is the
  // timestamp of any event of the set. Right while n times the square of the set's span, in us, is
  // below 2^64.
  Vector2 velocity(std::int64_t near) const noexcept;

  // Whether velocity() is right for a set of this span.
  bool resolves(std::uint64_t span_us) const noexcept {
    const auto span = static_cast<double>(span_us);
    return static_cast<double>(n_) * span * span < 0x1p63;
  }

 private:
  std::uint64_t n_ = 0;
  std::uint64_t x_ = 0;
  std::uint64_t y_ = 0;
  std::uint64_t xx_ = 0;
  std::uint64_t xy_ = 0;
  std::uint64_t yy_ = 0;
  std::uint64_t t_ = 0;
  std::uint64_t tt_ = 0;
  std::uint64_t xt_ = 0;
  std::uint64_t yt_ = 0;
};

// The velocity of a cluster by regression over its chain of live events, px/us; 0 if all timestamps
// are equal. From the moments; where their sums of squared times overflow, in windows of minutes,
// by a walk over the chain, O(its events). Not per event: at the read-out. `newest` is the chain's
// newest event, `moments` are the chain's.
Vector2 chain_velocity(const EventWindow& window, EventWindow::Position newest,
                       const WindowMoments& moments) noexcept;

}  // namespace asap::inline v0_1
