#include "live_setup.hpp"

#include <array>
#include <cstdio>
#include <utility>

#include "reference_filter.hpp"

namespace asap::simulation {

bool LiveSetup::passes(const Event& event) const noexcept {
  const auto place = static_cast<std::uint64_t>(event.x) << 17U |
                     static_cast<std::uint64_t>(event.y) << 1U |
                     static_cast<std::uint64_t>(event.p);
  return passing >= 1 ||
         event_number(filter_key, place) < static_cast<std::uint64_t>(passing * 0x1.0p63);
}

LiveSetup draw_live(Setup& setup) {
  Draw draw(setup.seed, 9);
  setup.by_arrival = true;
  LiveSetup live;
  const std::size_t policy = draw.below(4);
  live.when_full = policy < 2    ? WhenFull::thin
                   : policy == 2 ? WhenFull::keep_oldest
                                 : WhenFull::keep_newest;
  if (draw.chance(0.3)) live.passing = 0.1 + 0.8 * draw.uniform();
  live.filter_key = draw.bits();
  live.own_loop = setup.execution == Execution::whole && draw.chance(0.5);
  constexpr std::array<std::int64_t, 3> kPatiences{0, 1'000'000, 20'000'000};
  live.patience_ns = live.own_loop ? kPatiences[draw.below(kPatiences.size())] : 20'000'000;
  if (draw.chance(0.7)) live.asks = draw.octaves(0.001, 0.05);
  live.abandoned_at = draw.below(10 * setup.events);
  return live;
}

RunConfig run_config(const Setup& setup, FrontFilter before, WhenFull when_full) {
  return {.latency = std::chrono::nanoseconds(setup.latency_ns),
          .capacity = setup.capacity,
          .seed = setup.filter_seed,
          .validator = setup.door,
          .execution = setup.execution,
          .flush = setup.flush,
          .front_filter = std::move(before),
          .when_full = when_full};
}

std::string text(const LiveSetup& live) {
  constexpr std::array kPolicies{"thin", "keep_oldest", "keep_newest", "block"};
  std::array<char, 256> line{};
  std::snprintf(
      line.data(), line.size(),
      "  live: full ring %s, passing the filter in front %.3f, %s, patience %.3f ms, asks "
      "%.4f, abandoned at %zu\n",
      kPolicies[static_cast<std::size_t>(live.when_full)], live.passing,
      live.own_loop ? "next()" : "run()", static_cast<double>(live.patience_ns) * 1e-6, live.asks,
      live.abandoned_at);
  return line.data();
}

}  // namespace asap::simulation
