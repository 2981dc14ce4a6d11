// The surfaces and the plane-fit flow, written down as they are defined: borders tested pixel by
// pixel, times in 64 bits, means removed before the sums. Oracles of the fast forms and their
// rivals in the benchmarks.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "algorithms/naive_corners.hpp"
#include "asap/core/event.hpp"

namespace asap::test {

// One plane of ints.
class NaiveSurface {
 public:
  NaiveSurface(int width, int height)
      : width_(width),
        height_(height),
        values_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {}

  int& at(int x, int y) { return values_[static_cast<std::size_t>(y * width_ + x)]; }
  const std::vector<int>& values() const { return values_; }

 protected:
  template <class Change>
  void for_window(const Event& event, int reach, Change&& change) {
    for (int y = event.y - reach; y <= event.y + reach; ++y) {
      for (int x = event.x - reach; x <= event.x + reach; ++x) {
        if (0 <= x && x < width_ && 0 <= y && y < height_) change(at(x, y));
      }
    }
  }

 private:
  int width_;
  int height_;
  std::vector<int> values_;
};

class NaiveThresholdOrdinalSurface : public NaiveSurface {
 public:
  NaiveThresholdOrdinalSurface(int width, int height, int side)
      : NaiveSurface(width, height), side_(side) {}

  void update(const Event& event) {
    for_window(event, side_ / 2, [&](int& value) {
      value -= 1;
      if (value < 255 - 2 * side_) value = 0;
    });
    at(event.x, event.y) = 255;
  }

 private:
  int side_;
};

class NaiveSpeedInvariantTimeSurface : public NaiveSurface {
 public:
  NaiveSpeedInvariantTimeSurface(int width, int height, int radius)
      : NaiveSurface(width, height), radius_(radius) {}

  void update(const Event& event) {
    const int own = at(event.x, event.y);
    for_window(event, radius_, [&](int& value) {
      if (value > own) value -= 1;
    });
    at(event.x, event.y) = (2 * radius_ + 1) * (2 * radius_ + 1);
  }

 private:
  int radius_;
};

struct NaiveFlow {
  double vx;  // px/s
  double vy;
};

struct NaiveFlowRule {
  int reach;              // px from the event
  double half_px2;        // a pixel at this squared distance counts half
  int trims;              // how often the outliers are dropped
  double far;             // an outlier: the square of its distance over the mean square
  double scatter_px;      // the most along the normal
  std::int64_t burst_us;  // so soon after another at its pixel an event has no flow; -1: each has
};

constexpr double kNaiveAny = std::numeric_limits<double>::infinity();

constexpr NaiveFlowRule naive_flow_rule(std::optional<bool> refit, std::int64_t window_us) {
  if (!refit) return {3, 4, 2, 2.25, 0.7, window_us / 4};
  return {2, kNaiveAny, *refit ? 1 : 0, 4, kNaiveAny, -1};
}

class NaivePlaneFlow {
 public:
  NaivePlaneFlow(int width, int height, std::int64_t window_us, std::size_t min_points,
                 std::optional<bool> refit)
      : surface_(width, height, std::nullopt),
        latest_(width, height, std::nullopt),
        window_us_(window_us),
        min_points_(min_points),
        rule_(naive_flow_rule(refit, window_us)) {}

  std::optional<NaiveFlow> update(const Event& event) {
    last_us_ = std::max(last_us_, event.t);
    const int p = event.p > 0 ? 1 : 0;
    const Stamp before = std::exchange(latest_.at(event.x, event.y, p), last_us_);
    if (before && Wide{last_us_} - *before <= rule_.burst_us) return std::nullopt;
    surface_.at(event.x, event.y, p) = last_us_;
    gather(event, p);
    for (int trims = 0;; ++trims) {
      if (points_.size() < min_points_ || !fit()) return std::nullopt;
      if (trims == rule_.trims || !drop_outliers()) break;
    }
    const double squared = a_ * a_ + b_ * b_;
    if (squared < 1e-6) return std::nullopt;
    if (rule_.scatter_px < kNaiveAny) {
      const auto n = static_cast<double>(points_.size());
      if (n <= 3 || !(std::sqrt(mean_square() * n / (n - 3) / squared) <= rule_.scatter_px)) {
        return std::nullopt;
      }
    }
    return NaiveFlow{1e6 * a_ / squared, 1e6 * b_ / squared};
  }

 private:
  struct Point {
    double x, y, t, weight;
  };

  void gather(const Event& event, int p) {
    points_.clear();
    for (int y = event.y - rule_.reach; y <= event.y + rule_.reach; ++y) {
      for (int x = event.x - rule_.reach; x <= event.x + rule_.reach; ++x) {
        if (!surface_.has(x, y)) continue;
        const Stamp stamp = surface_.at(x, y, p);
        if (!stamp || Wide{last_us_} - *stamp > window_us_) continue;
        const double dx = x - event.x;
        const double dy = y - event.y;
        points_.push_back({dx, dy, static_cast<double>(*stamp - last_us_),
                           1 / (1 + (dx * dx + dy * dy) / rule_.half_px2)});
      }
    }
  }

  bool fit() {
    double sum = 0;
    for (const Point& point : points_) sum += point.weight;
    Point mean{0, 0, 0, 0};
    for (const Point& point : points_) {
      mean.x += point.weight * point.x / sum;
      mean.y += point.weight * point.y / sum;
      mean.t += point.weight * point.t / sum;
    }
    double sxx = 0, sxy = 0, syy = 0, sxt = 0, syt = 0;
    for (const Point& point : points_) {
      const double x = point.x - mean.x;
      const double y = point.y - mean.y;
      const double t = point.t - mean.t;
      sxx += point.weight * x * x;
      sxy += point.weight * x * y;
      syy += point.weight * y * y;
      sxt += point.weight * x * t;
      syt += point.weight * y * t;
    }
    const double determinant = sxx * syy - sxy * sxy;
    if (determinant < 1e-3) return false;
    a_ = (sxt * syy - syt * sxy) / determinant;
    b_ = (syt * sxx - sxt * sxy) / determinant;
    c_ = mean.t - a_ * mean.x - b_ * mean.y;
    return true;
  }

  double square(const Point& point) const {
    const double distance = point.t - (a_ * point.x + b_ * point.y + c_);
    return distance * distance;
  }

  double mean_square() const {
    double squares = 0;
    double weights = 0;
    for (const Point& point : points_) {
      squares += point.weight * square(point);
      weights += point.weight;
    }
    return squares / weights;
  }

  bool drop_outliers() {
    const double limit = std::max(1.0, rule_.far * mean_square());
    return std::erase_if(points_, [&](const Point& point) { return square(point) > limit; }) > 0;
  }

  Planes<Stamp> surface_;
  Planes<Stamp> latest_;
  std::int64_t window_us_;
  std::size_t min_points_;
  NaiveFlowRule rule_;
  std::int64_t last_us_ = std::numeric_limits<std::int64_t>::min();
  std::vector<Point> points_;
  double a_ = 0, b_ = 0, c_ = 0;
};

}  // namespace asap::test
