#include "hostile_scheme.hpp"

#include <array>
#include <limits>

namespace asap::simulation {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::size_t kHuge = std::numeric_limits<std::size_t>::max();

}  // namespace

Decision HostileScheme::decide(const Backlog& backlog) noexcept {
  const std::array<double, 10> keeps{0,    1, 0x1.0p-53, kNaN,       -1,
                                     -0.0, 2, kInfinity, -kInfinity, draw_.uniform()};
  const std::array<std::int64_t, 7> times{
      kLongAgo,  kNever, 0, -1, backlog.now_ns, backlog.now_ns + draw_.between(-1000, 1'000'000),
      kNever - 1};
  const std::array<double, 7> costs{0, kNaN, -1, kInfinity, 1e308, 1e-308, 1000 * draw_.uniform()};
  const std::array<std::size_t, 6> counts{
      0, 1, kHuge, kHuge - 1, backlog.count, draw_.below(backlog.count + 1)};
  const auto any = [&](const auto& values) { return values[draw_.below(values.size())]; };
  return {.takes = draw_.chance(0.6),
          .until_ns = any(times),
          .until_count = any(counts),
          .stale = draw_.chance(0.7) ? 0 : any(counts),
          .raw = any(counts),
          .gamma = any(keeps),
          .budget_ns = draw_.chance(0.5) ? draw_.between(-1000, 10'000'000) : any(times),
          .fixed_ns = any(costs),
          .event_ns = any(costs),
          .max_event_ns = any(costs)};
}

}  // namespace asap::simulation
