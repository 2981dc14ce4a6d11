// DeadlineReference: the law of Deadline (notebooks/theory.md, section 6) written down once more,
// as directly as possible.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "support/fake_backlog.hpp"

namespace asap::test {

struct DeadlineReference {
  const FakeBacklog& events;
  std::int64_t now_ns;
  double latency, fixed, event, price;
  bool continuous;
  static constexpr int kSlots = 32;

  double work(int slot) const {
    const Backlog all = events.at(now_ns);
    const auto step = static_cast<std::int64_t>(latency / kSlots);
    return event * static_cast<double>(all.count - all.counts.before(now_ns - slot * step));
  }
  double curve(const std::vector<double>& values, double age) const {
    const double at = std::clamp(age / latency * kSlots, 0.0, 1.0 * kSlots);
    const auto k = std::min(static_cast<std::size_t>(at), values.size() - 2);
    return values[k] + (at - static_cast<double>(k)) * (values[k + 1] - values[k]);
  }
  double age(const std::vector<double>& values, double value) const {
    for (std::size_t k = values.size() - 1; k-- > 0;) {
      if (value >= values.back()) return latency;
      if (values[k] <= value) {
        const double share = (value - values[k]) / (values[k + 1] - values[k]);
        return value <= 0 ? 0 : (static_cast<double>(k) + share) * latency / kSlots;
      }
    }
    return 0;
  }

  struct Curves {
    std::vector<double> c, b;
  };
  Curves curves() const {
    Curves result;
    double lead = 0;
    for (int k = 0; k <= kSlots; ++k) {
      result.c.push_back(k == 0 ? 0 : work(k));
      lead = std::max(lead, k * latency / kSlots - result.c.back());
      result.b.push_back(result.c.back() + lead);
    }
    return result;
  }
  double oldest() const { return static_cast<double>(events.at(now_ns).age_ns()); }

  struct Plan {
    double value = -1e300, length = 0, size = 0, stay = 0;
  };
  Plan played(double length, const Curves& of) const {
    const auto& [c, b] = of;
    const bool rush = curve(c, latency / 10) >= latency / 10;
    double max = latency;
    if (continuous) max = std::min(latency / 2, latency - oldest());
    if (continuous && latency - oldest() < 1.5 * fixed) max = latency / 2;
    if (length < 1.5 * fixed || length > max) return {};
    const double kept = latency - length;
    const double size = std::min(length - fixed, curve(c, kept));
    if (size <= 0) return {};
    const double next = rush ? (continuous ? length : fixed) : std::min(length, 3 * fixed);
    const double stay = std::max(
        0.0, std::min({age(b, kept - 2 * fixed), kept - next, age(c, curve(c, kept) - size)}));
    double value = size - fixed, now = fixed + size, x = stay, left = curve(c, x), last = size;
    for (int k = 0; k < 3 && left >= event; ++k) {
      if (fixed + left + now + x <= latency) {
        value += left - fixed;
        left = 0;
        break;
      }
      const double room = std::max(latency - now - x, 6 * fixed);
      x = std::min(x, latency - now - room);
      left = curve(c, x);
      last = std::min(left, room - fixed);
      if (last <= 0) {
        left = 0;
        break;
      }
      value += last - fixed;
      now += fixed + last;
      left -= last;
      x = age(c, left);
    }
    if (left >= event) value += 0.9 * left - fixed * left / last;
    if (rush) {
      const double gap = std::max(0.0, oldest() - kept) + std::max(0.0, stay + length - kept);
      value += 6 * latency * (size / (fixed + size) - price * gap * gap / latency / latency);
    }
    return {value, length, size, curve(c, stay)};
  }

  Plan best() const {
    const Curves of = curves();
    std::vector<double> lengths;
    for (int i = 1; i <= 8; ++i) lengths.push_back(0.98 * latency * i / 8);
    lengths.push_back(latency - oldest());
    double low = 0, high = latency;  // newest only
    for (int k = 0; k < 60; ++k) {
      const double middle = (low + high) / 2;
      (fixed + curve(of.c, middle) + middle <= latency ? low : high) = middle;
    }
    lengths.push_back(fixed + curve(of.c, low));
    Plan best;
    for (const double length : lengths) {
      const Plan plan = played(length, of);
      if (plan.value > best.value) best = plan;
    }
    return best;
  }
};

}  // namespace asap::test
