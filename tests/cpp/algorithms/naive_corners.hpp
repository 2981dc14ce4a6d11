// The corner detectors and the background-activity filter, written down as they are defined: times
// in 64 bits, no mask, no table, queues sorted for every event. Oracles of the fast forms and their
// rivals in the benchmarks.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "algorithms/corner_ring.hpp"
#include "asap/core/event.hpp"

namespace asap::test {

// A grid of the sensor's size, one plane per polarity.
template <class Value>
class Planes {
 public:
  Planes(int width, int height, Value value)
      : width_(width),
        height_(height),
        values_(2 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height), value) {}

  Value& at(int x, int y, int p) {
    return values_[static_cast<std::size_t>((p * height_ + y) * width_ + x)];
  }
  bool has(int x, int y) const { return 0 <= x && x < width_ && 0 <= y && y < height_; }
  bool has_ring(int x, int y) const {
    return 4 <= x && x < width_ - 4 && 4 <= y && y < height_ - 4;
  }

 private:
  int width_;
  int height_;
  std::vector<Value> values_;
};

__extension__ typedef __int128 Wide;        // differences of stamps
using Stamp = std::optional<std::int64_t>;  // nothing: never; less than every stamp

template <const auto& kPixels>
std::vector<Stamp> ring_of(Planes<Stamp>& surface, const Event& event) {
  std::vector<Stamp> values;
  for (const RingPixel& pixel : kPixels) {
    values.push_back(surface.at(event.x + pixel.dx, event.y + pixel.dy, event.p));
  }
  return values;
}

class NaiveEFast {
 public:
  NaiveEFast(int width, int height) : surface_(width, height, std::nullopt) {}

  bool update(const Event& event) {
    surface_.at(event.x, event.y, event.p) = event.t;
    return surface_.has_ring(event.x, event.y) &&
           has_newest_arc(ring_of<kRing3>(surface_, event), 3, 6) &&
           has_newest_arc(ring_of<kRing4>(surface_, event), 4, 8);
  }

 private:
  static bool has_newest_arc(const std::vector<Stamp>& ring, std::size_t shortest,
                             std::size_t longest) {
    const std::size_t n = ring.size();
    for (std::size_t length = shortest; length <= longest; ++length) {
      for (std::size_t start = 0; start < n; ++start) {
        Stamp oldest = ring[start];
        for (std::size_t i = 1; i < length; ++i) oldest = std::min(oldest, ring[(start + i) % n]);
        Stamp rest = ring[(start + length) % n];
        for (std::size_t i = length; i < n; ++i) rest = std::max(rest, ring[(start + i) % n]);
        if (oldest > rest) return true;
      }
    }
    return false;
  }

  Planes<Stamp> surface_;
};

class NaiveArcFilter {
 public:
  NaiveArcFilter(int width, int height, std::int64_t window_us)
      : window_us_(window_us), last_(width, height, std::nullopt) {}

  bool passes(const Event& event) {
    // A pixel counts as fired at 0, or just before a first stamp that is not positive.
    if (!has_started_) never_ = std::min<Wide>(0, Wide{event.t} - 1);
    has_started_ = true;
    const auto time = [&](int p) {
      const Stamp& last = last_.at(event.x, event.y, p);
      return last ? Wide{*last} : never_;
    };
    const bool passes = event.t - time(event.p) > window_us_ || time(1 - event.p) > time(event.p);
    last_.at(event.x, event.y, event.p) = event.t;
    return passes;
  }

 private:
  std::int64_t window_us_;
  bool has_started_ = false;
  Wide never_ = 0;
  Planes<Stamp> last_;
};

inline int naive_arc_length(const std::vector<Stamp>& ring, int shortest) {
  const int n = static_cast<int>(ring.size());
  const auto value = [&](int i) { return ring[static_cast<std::size_t>((i % n + n) % n)]; };
  const int newest = static_cast<int>(std::max_element(ring.begin(), ring.end()) - ring.begin());
  Stamp oldest = value(newest);
  int left = newest - 1;
  int right = newest + 1;
  Stamp left_min = value(left);
  Stamp right_min = value(right);
  int length = shortest;
  for (int taken = 1; taken < n; ++taken) {
    const bool to_the_right = value(right) > value(left);
    const Stamp candidate = to_the_right ? value(right) : value(left);
    const Stamp side_min = to_the_right ? right_min : left_min;
    if (taken < shortest) {
      oldest = std::min(oldest, side_min);
    } else if (candidate >= oldest) {
      length = taken + 1;
      oldest = std::min(oldest, side_min);
    }
    if (to_the_right) {
      right_min = std::min(right_min, value(++right));
    } else {
      left_min = std::min(left_min, value(--left));
    }
  }
  return length;
}

inline bool naive_corner_arcs(Planes<Stamp>& surface, const Event& event) {
  const int inner = naive_arc_length(ring_of<kRing3>(surface, event), 3);
  if (!(inner <= 6 || (10 <= inner && inner <= 13))) return false;
  const int outer = naive_arc_length(ring_of<kRing4>(surface, event), 4);
  return outer <= 8 || (12 <= outer && outer <= 16);
}

class NaiveArcStar {
 public:
  NaiveArcStar(int width, int height, std::int64_t filter_us = 50'000)
      : filter_(width, height, filter_us), surface_(width, height, std::nullopt) {}

  bool update(const Event& event) {
    if (!filter_.passes(event)) return false;
    surface_.at(event.x, event.y, event.p) = event.t;
    if (!surface_.has_ring(event.x, event.y)) return false;
    ++tested_;
    return naive_corner_arcs(surface_, event);
  }

  // Events that passed the filter off the border.
  std::size_t tested() const { return tested_; }

 private:
  NaiveArcFilter filter_;
  Planes<Stamp> surface_;
  std::size_t tested_ = 0;
};

using Patch = std::array<std::array<int, 9>, 9>;  // [y][x]

inline double naive_harris_score(const Patch& patch) {
  constexpr std::array<double, 5> kSmooth{1, 4, 6, 4, 1};
  constexpr std::array<double, 5> kDerive{1, 2, 0, -2, -1};
  double total = 0;
  double a = 0;
  double b = 0;
  double d = 0;
  for (int i = -2; i <= 2; ++i) {
    for (int j = -2; j <= 2; ++j) {
      double gx = 0;
      double gy = 0;
      for (std::size_t k = 0; k < 5; ++k) {
        for (std::size_t l = 0; l < 5; ++l) {
          const int pixel =
              patch[static_cast<std::size_t>(i + 2) + k][static_cast<std::size_t>(j + 2) + l];
          gx += kSmooth[k] * kDerive[l] * pixel / 12;
          gy += kDerive[k] * kSmooth[l] * pixel / 12;
        }
      }
      const double weight = std::exp(-(i * i + j * j) / 2.0);
      total += weight;
      a += weight * gx * gx;
      b += weight * gx * gy;
      d += weight * gy * gy;
    }
  }
  a /= total;
  b /= total;
  d /= total;
  return a * d - b * b - 0.04 * (a + d) * (a + d);
}

// The 25 latest distinct pixels of the window around each pixel, in a queue per pixel, the newest
// in front: the form of the public implementation.
class NaivePatches {
 public:
  NaivePatches(int width, int height) : queues_(width, height, {}) {}

  void add(const Event& event) {
    for (int dy = -4; dy <= 4; ++dy) {
      for (int dx = -4; dx <= 4; ++dx) {
        if (!queues_.has(event.x + dx, event.y + dy)) continue;
        Queue& queue = queues_.at(event.x + dx, event.y + dy, event.p);
        const std::pair<int, int> pixel{event.x, event.y};
        const auto found = std::find(queue.begin(), queue.end(), pixel);
        if (found != queue.end()) queue.erase(found);
        queue.push_front(pixel);
        if (queue.size() > 25) queue.pop_back();
      }
    }
  }

  std::optional<Patch> around(const Event& event) {
    const Queue& queue = queues_.at(event.x, event.y, event.p);
    if (queue.size() < 25) return std::nullopt;
    Patch patch{};
    for (const auto& [x, y] : queue) {
      patch[static_cast<std::size_t>(y - event.y + 4)][static_cast<std::size_t>(x - event.x + 4)] =
          1;
    }
    return patch;
  }

 private:
  using Queue = std::deque<std::pair<int, int>>;
  Planes<Queue> queues_;
};

class NaiveEHarris {
 public:
  NaiveEHarris(int width, int height, double threshold = 8)
      : width_(width), height_(height), threshold_(threshold), patches_(width, height) {}

  bool update(const Event& event) {
    patches_.add(event);
    if (event.x < 4 || event.x > width_ - 4 || event.y < 4 || event.y > height_ - 4) return false;
    const auto patch = patches_.around(event);
    return patch && naive_harris_score(*patch) > threshold_;
  }

 private:
  int width_;
  int height_;
  double threshold_;
  NaivePatches patches_;
};

// The 25 newest pixels by sorting the window for every candidate, as in the release.
class NaiveFAHarris {
 public:
  NaiveFAHarris(int width, int height, std::int64_t filter_us = 50'000, double threshold = 8)
      : threshold_(threshold),
        filter_(width, height, filter_us),
        surface_(width, height, std::nullopt),
        arrivals_(width, height, 0) {}

  bool update(const Event& event) {
    if (!surface_.has_ring(event.x, event.y) || !filter_.passes(event)) return false;
    surface_.at(event.x, event.y, event.p) = event.t;
    arrivals_.at(event.x, event.y, event.p) = ++count_;
    if (!naive_corner_arcs(surface_, event)) return false;

    std::vector<std::array<std::size_t, 3>> window;  // arrival, y, x
    for (std::size_t y = 0; y < 9; ++y) {
      for (std::size_t x = 0; x < 9; ++x) {
        const std::size_t arrival = arrivals_.at(event.x + static_cast<int>(x) - 4,
                                                 event.y + static_cast<int>(y) - 4, event.p);
        if (arrival > 0) window.push_back({arrival, y, x});
      }
    }
    if (window.size() < 25) return false;
    std::sort(window.rbegin(), window.rend());
    Patch patch{};
    for (std::size_t i = 0; i < 25; ++i) patch[window[i][1]][window[i][2]] = 1;
    return naive_harris_score(patch) > threshold_;
  }

 private:
  double threshold_;
  NaiveArcFilter filter_;
  Planes<Stamp> surface_;
  Planes<std::size_t> arrivals_;
  std::size_t count_ = 0;
};

class NaiveBackgroundActivityFilter {
 public:
  NaiveBackgroundActivityFilter(int width, int height, std::int64_t window_us)
      : window_us_(window_us), last_(width, height, std::nullopt) {}

  bool update(const Event& event) {
    Stamp newest;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        if ((dx != 0 || dy != 0) && last_.has(event.x + dx, event.y + dy)) {
          newest = std::max(newest, last_.at(event.x + dx, event.y + dy, 0));
        }
      }
    }
    last_.at(event.x, event.y, 0) = event.t;
    return newest && static_cast<Wide>(event.t) - *newest <= window_us_;
  }

 private:
  std::int64_t window_us_;
  Planes<Stamp> last_;
};

template <class Naive>
std::vector<std::uint8_t> naive_labels(Naive naive, EventSpan events) {
  std::vector<std::uint8_t> labels;
  for (const Event& event : events) labels.push_back(naive.update(event));
  return labels;
}

}  // namespace asap::test
