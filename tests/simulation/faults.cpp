#include "faults.hpp"

#include <array>
#include <cstdio>
#include <limits>

namespace asap::simulation {
namespace {

std::size_t draw_odd_capacity(Draw& draw) {
  const std::size_t power = std::size_t{1} << draw.below(12);
  return draw.chance(0.3) ? 1 + draw.below(2) : power + draw.below(3) - (power > 1 ? 1 : 0);
}

}  // namespace

std::vector<Fault> draw_faults(const Setup& setup, unsigned mask) {
  Draw draw(setup.seed, 4);
  std::vector<Fault> faults;
  const std::size_t count = draw.below(kMaxFaults + 1);
  for (std::size_t i = 0; i < count; ++i) {
    const auto kind = static_cast<FaultKind>(draw.below(kFaultKinds));
    const std::size_t begin = draw.below(setup.faults_end());
    const std::size_t end = begin + 1 + draw.below(setup.faults_end() - begin);
    const std::uint64_t key = draw.bits();
    if ((mask >> i & 1U) != 0) faults.push_back({kind, begin, end, key});
  }
  return faults;
}

void configure(Setup& setup, const std::vector<Fault>& faults) {
  for (const Fault& fault : faults) {
    Draw draw = fault.draw();
    if (fault.kind == FaultKind::odd_ring) setup.capacity = draw_odd_capacity(draw);
    if (fault.kind == FaultKind::extreme) {
      if (draw.chance(0.6)) {
        setup.scheme.kind = Kind::hostile;
        setup.scheme.min_gamma = 0;
      }
      if (draw.chance(0.5)) {
        setup.filter_seed = draw.chance(0.5) ? 0 : std::numeric_limits<std::uint64_t>::max();
      }
    }
  }
}

void reconfigure(Setup& setup, const Fault& fault) {
  Draw draw = fault.draw();
  setup.latency_ns = 1000 * static_cast<std::int64_t>(draw.octaves(50, 50'000));
  setup.execution = draw.chance(0.5) ? Execution::anytime : Execution::whole;
  if (draw.chance(0.5)) setup.capacity = 1 + draw.below(5000);
  setup.scheme = draw_scheme(draw, setup, static_cast<std::size_t>(Kind::hostile));
}

std::string text(const std::vector<Fault>& faults) {
  constexpr std::array<const char*, kFaultKinds> kNames{
      "F1 slower",    "F2 stall",   "F3 odd cost",  "F4 exception",   "F5 gone",
      "F6 rate",      "F7 silence", "F8 anomalies", "F9 reconfigure", "F10 restart",
      "F11 odd ring", "F12 stop",   "F16 extreme"};
  std::string all;
  std::array<char, 128> line{};
  for (const Fault& fault : faults) {
    std::snprintf(line.data(), line.size(), "  fault %s, events %zu to %zu\n",
                  kNames[static_cast<std::size_t>(fault.kind)], fault.begin, fault.end);
    all += line.data();
  }
  return all.empty() ? "  no fault\n" : all;
}

}  // namespace asap::simulation
