#include "algorithms/chain_velocity.hpp"

#include <cstdint>

namespace asap {
namespace {

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

Vector2 chain_velocity(const EventWindow& window, EventWindow::Position newest,
                       const WindowMoments& moments) noexcept {
  const std::int64_t now = window[newest].t;
  const auto span = static_cast<std::uint64_t>(now) - static_cast<std::uint64_t>(window.oldest_t());
  return moments.resolves(span) ? moments.velocity(now) : walked_velocity(window, newest, moments);
}

}  // namespace asap
