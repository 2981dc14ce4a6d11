// ReferencePlan: the strata of an anytime package, from notebooks/theory.md, section 7. Which
// events a stratum keeps follows from the seed, their numbers and the threshold alone.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "asap/schemes/scheme.hpp"

namespace asap::simulation {

// The number that decides an event: SplitMix64, 63 bits.
inline std::uint64_t event_number(std::uint64_t seed, std::uint64_t index) noexcept {
  constexpr std::uint64_t kStep = 0x9e3779b97f4a7c15U;
  const auto shuffled = [](std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9U;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebU;
    return z ^ (z >> 31);
  };
  return shuffled(shuffled(seed + kStep) + index * kStep) >> 1;
}

class ReferencePlan {
 public:
  ReferencePlan() = default;
  ReferencePlan(const Decision& decision, std::int64_t start_ns, std::int64_t grace_ns)
      : raw_(decision.raw),
        strata_(count(decision)),
        probe_(probe(decision, strata_)),
        planned_(decision.keep * static_cast<double>(raw_)),
        end_ns_(start_ns + std::clamp<std::int64_t>(decision.budget_ns, 0, 1'000'000'000'000'000)),
        grace_ns_(grace_ns),
        fixed_ns_(decision.fixed_ns > 0 ? std::min(std::floor(decision.fixed_ns), 1e15) : 0),
        start_ns_(start_ns),
        events_(std::max(1.0, trust(decision) * (planned_ / 32))),
        spent_ns_(events_ * (decision.event_ns > 0 ? decision.event_ns : 0)) {}

  struct Stratum {
    std::size_t begin;
    std::size_t end;  // begin == end: done
    double keep;
    bool is_last;
  };

  // `size` events were kept of the stratum before.
  Stratum next(std::int64_t now_ns, std::size_t size) noexcept {
    if (parts_ > 0) {
      const auto part_ns = static_cast<double>(now_ns - stratum_start_ns_);
      spent_ns_ += parts_ > 1 ? part_ns : first_ns(part_ns, now_ns, static_cast<double>(size));
      events_ += static_cast<double>(size);
      if (now_ns > end_ns_ + grace_ns_) return {0, 0, 0, false};
    }
    if (done_ == strata_) return {0, 0, 0, false};
    const bool is_probe = probe_ > 0 && parts_ == 0;
    const std::size_t j = done_;
    ++parts_;
    done_ += is_probe ? 0 : 1;
    stratum_start_ns_ = now_ns;
    const auto count = static_cast<double>(strata_);
    const double raw = static_cast<double>(raw_) / count;
    const double passed_ns = static_cast<double>(now_ns - start_ns_);
    double left_ns = static_cast<double>(end_ns_ - now_ns) / static_cast<double>(strata_ - j);
    if (strata_ == 1 && fixed_ns_ > passed_ns) left_ns -= fixed_ns_ - passed_ns;
    const double event_ns = spent_ns_ / events_;
    double size_planned = left_ns / event_ns;
    if (event_ns * raw <= left_ns) size_planned = raw;
    const double least = std::max(0.02 * planned_ / count, j == 0 ? 1.0 : 0.0);
    if (!(size_planned >= least)) size_planned = least;
    const std::size_t begin = j == 0 && !is_probe ? probe_ : raw_ * j / strata_;
    const std::size_t end = is_probe ? probe_ : raw_ * (j + 1) / strata_;
    return {begin, end, std::clamp(size_planned / raw, 0.0, 1.0), j + 1 == strata_};
  }

 private:
  // Of the first part: what goes beyond the fixed cost, or what was expected, if that is more. All,
  // if half of the fixed cost passed before.
  double first_ns(double part_ns, std::int64_t now_ns, double size) const noexcept {
    if (static_cast<double>(2 * (stratum_start_ns_ - start_ns_)) > fixed_ns_) return part_ns;
    const double beyond_ns = static_cast<double>(now_ns - start_ns_) - fixed_ns_;
    const double expected_ns = size * spent_ns_ / events_;
    return std::min(part_ns, beyond_ns > expected_ns ? beyond_ns : expected_ns);
  }

  static double trust(const Decision& decision) {
    const bool is_doubted = decision.most_event_ns > decision.event_ns;
    return is_doubted ? decision.event_ns / decision.most_event_ns : 1;
  }

  // Of 64 events, or shorter: none longer than a 16th of the budget, or 2 us.
  static std::size_t count(const Decision& decision) {
    const double raw = static_cast<double>(decision.raw);
    const double budget_ns = static_cast<double>(decision.budget_ns);
    const double most_ns =
        decision.event_ns < decision.most_event_ns ? decision.most_event_ns : decision.event_ns;
    double work_ns = decision.keep * raw * most_ns;
    if (!(work_ns < budget_ns)) work_ns = budget_ns;
    double strata = std::max(std::floor(raw / 64), work_ns / std::max(budget_ns / 16, 2000.0));
    strata = std::min({strata, raw, 16.0});
    return strata >= 1 ? static_cast<std::size_t>(strata) : 1;
  }

  // Of the first stratum: so many as are in time even if an event costs the most that it may.
  static std::size_t probe(const Decision& decision, std::size_t strata) {
    if (strata < 2 || decision.budget_ns <= 0) return 0;
    if (!(decision.most_event_ns > decision.event_ns)) return 0;
    const double share_ns = static_cast<double>(decision.budget_ns) / static_cast<double>(strata);
    double safe = share_ns / decision.most_event_ns;
    if (!(safe >= 1)) safe = 1;
    return safe < static_cast<double>(decision.raw / strata) ? static_cast<std::size_t>(safe) : 0;
  }

  std::size_t raw_ = 0;
  std::size_t strata_ = 0;
  std::size_t probe_ = 0;
  std::size_t parts_ = 0;
  double planned_ = 0;
  std::int64_t end_ns_ = 0;
  std::int64_t grace_ns_ = 0;
  double fixed_ns_ = 0;
  std::int64_t start_ns_ = 0;
  double events_ = 1;
  double spent_ns_ = 0;
  std::int64_t stratum_start_ns_ = 0;
  std::size_t done_ = 0;
};

// Appends the indices of [begin, end) that are kept.
class ReferenceFilter {
 public:
  explicit ReferenceFilter(std::uint64_t seed) noexcept : seed_(seed) {}

  void keep(std::uint64_t begin, std::uint64_t end, double gamma,
            std::vector<std::uint64_t>& kept) {
    const auto threshold = static_cast<std::uint64_t>(gamma * 0x1.0p63);
    for (std::uint64_t i = begin; i < end; ++i) {
      if (gamma >= 1 || event_number(seed_, i) < threshold) kept.push_back(i);
    }
  }

  // Those of the smallest numbers, so many of them as gamma says.
  void keep_exactly(std::uint64_t begin, std::uint64_t end, double gamma,
                    std::vector<std::uint64_t>& kept) {
    const auto size = static_cast<std::size_t>(gamma * static_cast<double>(end - begin) + 1e-6);
    if (size >= end - begin) return keep(begin, end, 1, kept);
    numbers_.clear();
    for (std::uint64_t i = begin; i < end; ++i) numbers_.push_back(event_number(seed_, i));
    sorted_ = numbers_;
    std::nth_element(sorted_.begin(), sorted_.begin() + static_cast<std::ptrdiff_t>(size),
                     sorted_.end());
    for (std::uint64_t i = begin; i < end; ++i) {
      if (numbers_[i - begin] < sorted_[size]) kept.push_back(i);
    }
  }

 private:
  const std::uint64_t seed_;
  std::vector<std::uint64_t> numbers_;
  std::vector<std::uint64_t> sorted_;
};

}  // namespace asap::simulation
