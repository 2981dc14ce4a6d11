#include "setup.hpp"

#include <array>
#include <cinttypes>
#include <cstdio>

#include "asap/schemes/asap2020.hpp"
#include "asap/schemes/asap2022.hpp"
#include "asap/schemes/dead_beat.hpp"
#include "asap/schemes/deadline.hpp"
#include "asap/schemes/fixed.hpp"
#include "asap/schemes/greedy.hpp"
#include "hostile_scheme.hpp"

namespace asap::simulation {
namespace {

constexpr std::size_t kEvents = 21'000;  // of the shortest run
constexpr std::size_t kKinds = 8;        // without the hostile one

std::size_t draw_capacity(Draw& draw, double events_per_bound) {
  // The roomy ones, which a fault may still fill, are those whose recovery can be judged.
  std::size_t capacity = 64;
  while (static_cast<double>(capacity) < 8 * events_per_bound) capacity *= 2;
  if (draw.chance(0.7)) return 16 * capacity;
  return capacity / 8 + draw.below(3) - 1;
}

ValidatorConfig draw_door(Draw& draw) {
  constexpr std::array kPolicies{OnBad::drop, OnBad::drop, OnBad::clamp, OnBad::raise};
  const bool bounded = draw.chance(0.8);
  return {.width = bounded ? static_cast<int>(draw.between(1, 1280)) : 0,
          .height = bounded ? static_cast<int>(draw.between(1, 720)) : 0,
          .on_bad = kPolicies[draw.below(kPolicies.size())],
          .reorder_tolerance =
              std::chrono::microseconds(draw.chance(0.7) ? 0 : draw.between(1, 999'999))};
}

double ms(std::int64_t time_ns) { return static_cast<double>(time_ns) * 1e-6; }
std::chrono::nanoseconds time_of(double time_ms) {
  return std::chrono::nanoseconds(std::llround(time_ms * 1e6));
}

Asap2020Config asap2020(const Setup& setup, Draw draw) {
  const double rate = 1e9 / setup.gap_ns;
  return {
      .rate_bound = rate * draw.octaves(0.1, 10),
      .epsilon = 0.5 * draw.uniform(),
      .first_size = setup.scheme.size + draw.below(setup.scheme.max_size - setup.scheme.size + 1),
      .max_size = setup.scheme.max_size,
      .min_size = setup.scheme.size};
}

Asap2022Config asap2022(const Setup& setup, Draw draw) {
  const double longest_ms = ms(setup.latency_ns) * draw.octaves(0.1, 2);
  const double min_gamma = draw.chance(0.3) ? 0.0 : 0.5 * draw.uniform();
  return {.min_processing = time_of(longest_ms * 0.5 * draw.uniform() + 1e-6),
          .max_processing = time_of(longest_ms + 1e-5),
          .min_size = setup.scheme.size,
          .max_size = setup.scheme.max_size,
          .kappa = draw.octaves(0.25, 4),
          .min_gamma = min_gamma,  // where its law aims; clipped to [0, 1] only
          .max_gamma = min_gamma + (1 - min_gamma) * 0.9,
          .first_size = 1 + draw.below(setup.scheme.max_size)};
}

double draw_overhead(Draw& draw) { return draw.chance(0.7) ? 0.25 : draw.uniform(); }
std::chrono::nanoseconds draw_interval(Draw& draw, const Setup& setup) {
  return time_of(draw.chance(0.8) ? 0.0 : ms(setup.latency_ns) * draw.uniform());
}

DeadlineConfig deadline(const Setup& setup, Draw draw) {
  DeadlineConfig config{.latency = std::chrono::nanoseconds(setup.latency_ns),
                        .overhead = draw_overhead(draw),
                        .min_interval = draw_interval(draw, setup)};
  if (!draw.chance(0.6)) config.prefer = draw.chance(0.5) ? Prefer::events : Prefer::continuity;
  if (draw.chance(0.3)) {
    config.first_alpha_us = draw.octaves(0.01, 1e5);
    config.first_beta_ns = draw.octaves(0.01, 1e5);
  }
  return config;
}

DeadBeatConfig dead_beat(const Setup& setup, Draw draw) {
  return {.latency = std::chrono::nanoseconds(setup.latency_ns),
          .knee = draw.chance(0.5) ? 33.0 : (draw.chance(0.5) ? 0.0 : draw.octaves(8, 100)),
          .overhead = draw_overhead(draw),
          .min_interval = draw_interval(draw, setup)};
}

const char* name(Kind kind) {
  constexpr std::array kNames{"fixed_size", "fixed_time", "single_event", "greedy", "asap2020",
                              "asap2022",   "deadline",   "dead_beat",    "hostile"};
  return kNames[static_cast<std::size_t>(kind)];
}

}  // namespace

SchemeSetup draw_scheme(Draw& draw, const Setup& setup, std::size_t kinds) {
  const double per_bound = static_cast<double>(setup.latency_ns) / setup.gap_ns;
  SchemeSetup scheme;
  // The two that keep a bound are the point of the library.
  const std::size_t drawn = draw.below(kinds + 4);
  const std::size_t bounded = static_cast<std::size_t>(Kind::deadline) + drawn % 2;
  scheme.kind = static_cast<Kind>(drawn < kinds ? drawn : bounded);
  scheme.size = static_cast<std::size_t>(draw.octaves(1, 2 + per_bound));
  scheme.max_size = scheme.size + static_cast<std::size_t>(draw.octaves(1, 2 + 4 * per_bound));
  scheme.period_ns =
      1000 * (1 + static_cast<std::int64_t>(draw.uniform() * ms(setup.latency_ns) * 1e3));
  scheme.efficiency = draw.chance(0.5) ? 0.0 : 0.3 + 0.69 * draw.uniform();
  scheme.key = draw.bits();
  if (scheme.kind == Kind::asap2020) scheme.min_gamma = 0.02;
  return scheme;
}

Setup draw_setup(std::uint64_t seed) {
  Draw draw(seed, 0);
  Setup setup;
  setup.seed = seed;
  setup.by_arrival = draw.chance(0.5);
  setup.execution = draw.chance(0.5) ? Execution::anytime : Execution::whole;
  setup.flush = draw.chance(0.95);
  setup.fixed_cost_first = draw.chance(0.5);
  setup.asks_stratum = draw.chance(0.5);
  setup.latency_ns = 1000 * static_cast<std::int64_t>(draw.octaves(50, 50'000));
  const double per_bound = draw.octaves(1, 256);
  setup.gap_ns = static_cast<double>(setup.latency_ns) / per_bound;
  setup.capacity = draw_capacity(draw, per_bound);
  setup.filter_seed = draw.bits();
  setup.door = draw_door(draw);
  setup.alpha_ns = static_cast<double>(setup.latency_ns) * draw.octaves(0.001, 0.1);
  setup.beta_ns = 1 + setup.gap_ns * draw.octaves(0.05, 4);
  setup.cost_noise = draw.chance(0.5) ? 0.0 : 0.2 * draw.uniform();
  setup.base_us = draw.between(-2'000'000, 2'000'000);
  if (draw.chance(0.1)) setup.base_us *= 1'000'000;
  setup.events = kEvents + draw.below(kEvents / 2);
  setup.longest_packet = static_cast<std::size_t>(draw.octaves(1, 2 + per_bound / 8));
  setup.lag_ns = draw.chance(0.5) ? 0 : setup.latency_ns / 200;
  setup.scheme = draw_scheme(draw, setup, kKinds);
  return setup;
}

std::unique_ptr<Scheme> make_scheme(const Setup& setup) {
  const Draw draw(setup.scheme.key, 1);
  switch (setup.scheme.kind) {
    case Kind::fixed_size:
      return std::make_unique<FixedSize>(FixedSizeConfig{.size = setup.scheme.size});
    case Kind::fixed_time:
      return std::make_unique<FixedTime>(
          FixedTimeConfig{.period = std::chrono::nanoseconds(setup.scheme.period_ns)});
    case Kind::single_event:
      return std::make_unique<SingleEvent>();
    case Kind::greedy:
      if (setup.scheme.efficiency == 0) return std::make_unique<Greedy>();
      return std::make_unique<Greedy>(GreedyConfig{.efficiency = setup.scheme.efficiency});
    case Kind::asap2020:
      return std::make_unique<Asap2020>(asap2020(setup, draw));
    case Kind::asap2022:
      return std::make_unique<Asap2022>(asap2022(setup, draw));
    case Kind::deadline:
      return std::make_unique<Deadline>(deadline(setup, draw));
    case Kind::dead_beat:
      return std::make_unique<DeadBeat>(dead_beat(setup, draw));
    case Kind::hostile:
      return std::make_unique<HostileScheme>(setup.scheme.key);
  }
  return nullptr;
}

Belief belief(const Setup& setup, const Scheme& scheme) {
  const auto of = [&](const auto& bounded) -> Belief {
    return {bounded.alpha_ns(), bounded.beta_ns()};
  };
  if (setup.scheme.kind == Kind::deadline) return of(static_cast<const Deadline&>(scheme));
  if (setup.scheme.kind == Kind::dead_beat) return of(static_cast<const DeadBeat&>(scheme));
  return {};
}

std::string text(const Setup& setup) {
  constexpr std::array kPolicies{"drop", "clamp", "raise"};
  std::array<char, 1024> line{};
  const SchemeSetup& scheme = setup.scheme;
  std::snprintf(
      line.data(), line.size(),
      "  clock %s, execution %s%s, bound %.3f ms, ring %zu, seed %" PRIu64
      ", flush %s, lag %.4f ms\n"
      "  scheme %s: size %zu..%zu, period %.3f ms, efficiency %.3f, gamma >= %.3f\n"
      "  cost %.3f us + %.1f ns, noise %.3f; events %zu, one per %.1f ns (load %.2f), packets <= "
      "%zu, from %" PRId64
      " us\n"
      "  door %dx%d, on_bad %s, tolerance %" PRId64 " us\n",
      setup.by_arrival ? "arrival" : "stamp",
      setup.execution == Execution::whole ? "whole" : "anytime",
      setup.fixed_cost_first ? "" : " (fixed cost in the first part)", ms(setup.latency_ns),
      setup.capacity, setup.filter_seed, setup.flush ? "on" : "off", ms(setup.lag_ns),
      name(scheme.kind), scheme.size, scheme.max_size, ms(scheme.period_ns), scheme.efficiency,
      scheme.min_gamma, setup.alpha_ns * 1e-3, setup.beta_ns, setup.cost_noise, setup.events,
      setup.gap_ns, setup.load(), setup.longest_packet, setup.base_us, setup.door.width,
      setup.door.height, kPolicies[static_cast<std::size_t>(setup.door.on_bad)],
      static_cast<std::int64_t>(setup.door.reorder_tolerance / std::chrono::microseconds(1)));
  return line.data();
}

}  // namespace asap::simulation
