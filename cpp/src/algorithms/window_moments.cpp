#include "algorithms/window_moments.hpp"

namespace asap::inline v0_1 {
namespace {

double as_signed(std::uint64_t value) {
  return static_cast<double>(static_cast<std::int64_t>(value));
}

Vector2 walked_velocity(const EventWindow& window, EventWindow::Position newest,
                        const WindowMoments& moments) noexcept {
  const std::int64_t now = window[newest].t;
  const auto n = static_cast<double>(moments.count());
  const Vector2 mean = moments.centroid();
  double t = 0, tt = 0, xt = 0, yt = 0;
  window.for_each(newest, [&](EventWindow::Position position) {
    const EventWindow::Entry& entry = window[position];
    const double age = static_cast<double>(now) - static_cast<double>(entry.t);
    t += age;
    tt += age * age;
    xt -= (entry.x - mean.x) * age;
    yt -= (entry.y - mean.y) * age;
  });
  const double spread = tt - t * t / n;
  if (!(spread > 0)) return {0, 0};
  return {xt / spread, yt / spread};
}

}  // namespace

WindowMoments& WindowMoments::operator+=(const WindowMoments& other) noexcept {
  n_ += other.n_;
  x_ += other.x_;
  y_ += other.y_;
  xx_ += other.xx_;
  xy_ += other.xy_;
  yy_ += other.yy_;
  t_ += other.t_;
  tt_ += other.tt_;
  xt_ += other.xt_;
  yt_ += other.yt_;
  return *this;
}

Vector2 WindowMoments::centroid() const noexcept {
  const auto n = static_cast<double>(n_);
  return {static_cast<double>(x_) / n, static_cast<double>(y_) / n};
}

// The numerators are n^2 times a variance of 16-bit numbers: they fit, whatever the products did.
Covariance WindowMoments::covariance() const noexcept {
  const auto n = static_cast<double>(n_);
  return {as_signed(n_ * xx_ - x_ * x_) / (n * n), as_signed(n_ * xy_ - x_ * y_) / (n * n),
          as_signed(n_ * yy_ - y_ * y_) / (n * n)};
}

Vector2 WindowMoments::velocity(std::int64_t near) const noexcept {
  // Sums about (x0, y0, t0), the mean up to its fraction: small, so the doubles lose no digits.
  const auto origin = static_cast<std::uint64_t>(near);
  const auto offset = static_cast<std::int64_t>(t_ - n_ * origin) / static_cast<std::int64_t>(n_);
  const std::uint64_t t0 = origin + static_cast<std::uint64_t>(offset);
  const std::uint64_t x0 = x_ / n_;
  const std::uint64_t y0 = y_ / n_;

  const auto n = static_cast<double>(n_);
  const double x = as_signed(x_ - n_ * x0);
  const double y = as_signed(y_ - n_ * y0);
  const double t = as_signed(t_ - n_ * t0);
  const auto tt = static_cast<double>(tt_ - 2 * t0 * t_ + n_ * t0 * t0);
  const double xt = as_signed(xt_ - t0 * x_ - x0 * t_ + n_ * x0 * t0);
  const double yt = as_signed(yt_ - t0 * y_ - y0 * t_ + n_ * y0 * t0);

  const double spread = tt - t * t / n;
  if (!(spread > 0)) return {0, 0};
  return {(xt - x * t / n) / spread, (yt - y * t / n) / spread};
}

Vector2 chain_velocity(const EventWindow& window, EventWindow::Position newest,
                       const WindowMoments& moments) noexcept {
  const std::int64_t now = window[newest].t;
  const auto span = static_cast<std::uint64_t>(now) - static_cast<std::uint64_t>(window.oldest_t());
  return moments.resolves(span) ? moments.velocity(now) : walked_velocity(window, newest, moments);
}

}  // namespace asap::inline v0_1
