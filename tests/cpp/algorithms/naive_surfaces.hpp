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

class NaivePlaneFlow {
 public:
  NaivePlaneFlow(int width, int height, std::int64_t window_us, std::size_t min_points, bool refit)
      : surface_(width, height, std::nullopt),
        window_us_(window_us),
        min_points_(min_points),
        refit_(refit) {}

  std::optional<NaiveFlow> update(const Event& event) {
    last_us_ = std::max(last_us_, event.t);
    const int p = event.p > 0 ? 1 : 0;
    surface_.at(event.x, event.y, p) = last_us_;
    points_.clear();
    for (int y = event.y - 2; y <= event.y + 2; ++y) {
      for (int x = event.x - 2; x <= event.x + 2; ++x) {
        if (!surface_.has(x, y)) continue;
        const Stamp stamp = surface_.at(x, y, p);
        if (!stamp || Wide{last_us_} - *stamp > window_us_) continue;
        points_.push_back({static_cast<double>(x - event.x), static_cast<double>(y - event.y),
                           static_cast<double>(*stamp - last_us_)});
      }
    }
    if (points_.size() < min_points_ || !fit()) return std::nullopt;
    if (refit_ && drop_outliers()) {
      if (points_.size() < min_points_ || !fit()) return std::nullopt;
    }
    const double squared = a_ * a_ + b_ * b_;
    if (squared < 1e-6) return std::nullopt;
    return NaiveFlow{1e6 * a_ / squared, 1e6 * b_ / squared};
  }

 private:
  struct Point {
    double x, y, t;
  };

  bool fit() {
    const auto n = static_cast<double>(points_.size());
    Point mean{0, 0, 0};
    for (const Point& point : points_) {
      mean.x += point.x / n;
      mean.y += point.y / n;
      mean.t += point.t / n;
    }
    double sxx = 0, sxy = 0, syy = 0, sxt = 0, syt = 0;
    for (const Point& point : points_) {
      const double x = point.x - mean.x;
      const double y = point.y - mean.y;
      const double t = point.t - mean.t;
      sxx += x * x;
      sxy += x * y;
      syy += y * y;
      sxt += x * t;
      syt += y * t;
    }
    const double determinant = sxx * syy - sxy * sxy;
    if (determinant < 1e-3) return false;
    a_ = (sxt * syy - syt * sxy) / determinant;
    b_ = (syt * sxx - sxt * sxy) / determinant;
    c_ = mean.t - a_ * mean.x - b_ * mean.y;
    return true;
  }

  bool drop_outliers() {
    const auto square = [this](const Point& point) {
      const double distance = point.t - (a_ * point.x + b_ * point.y + c_);
      return distance * distance;
    };
    double sum = 0;
    for (const Point& point : points_) sum += square(point);
    const double limit = std::max(1.0, 4 * sum / static_cast<double>(points_.size()));
    return std::erase_if(points_, [&](const Point& point) { return square(point) > limit; }) > 0;
  }

  Planes<Stamp> surface_;
  std::int64_t window_us_;
  std::size_t min_points_;
  bool refit_;
  std::int64_t last_us_ = std::numeric_limits<std::int64_t>::min();
  std::vector<Point> points_;
  double a_ = 0, b_ = 0, c_ = 0;
};

}  // namespace asap::test
