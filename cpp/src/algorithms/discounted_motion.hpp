// DiscountedMotion: the velocity of a point from its positions, by regression of x and y on t in
// which an older position weighs less: by memory / (memory + dt) with every step dt. Times count
// from the newest position, so nothing grows and no digits are lost. O(1) per position, no
// allocation. One thread.
#pragma once

namespace asap {

class DiscountedMotion {
 public:
  struct Velocity {
    double x;
    double y;
  };

  // A position `dt` after the one before; `memory` > 0 is in the unit of `dt`.
  void add(double x, double y, double dt, double memory) noexcept {
    const double keep = memory / (memory + dt);
    // Old before new: each line uses the sums of the position before.
    tt_ = keep * (tt_ - dt * (2 * t_ - dt * n_));
    xt_ = keep * (xt_ - dt * x_);
    yt_ = keep * (yt_ - dt * y_);
    t_ = keep * (t_ - dt * n_);
    x_ = keep * x_ + x;
    y_ = keep * y_ + y;
    n_ = keep * n_ + 1;
  }

  // Per unit of time. 0 until there are positions at two times.
  Velocity velocity() const noexcept {
    const double spread = n_ * tt_ - t_ * t_;
    if (!(spread > 0)) return {0, 0};
    return {(n_ * xt_ - x_ * t_) / spread, (n_ * yt_ - y_ * t_) / spread};
  }

 private:
  // Discounted sums; t = 0 at the newest position, negative before.
  double n_ = 0;
  double t_ = 0;
  double tt_ = 0;
  double x_ = 0;
  double y_ = 0;
  double xt_ = 0;
  double yt_ = 0;
};

}  // namespace asap
