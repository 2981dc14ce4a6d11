#include "trial.hpp"

#include <algorithm>
#include <optional>

#include "life.hpp"
#include "live_life.hpp"
#include "live_setup.hpp"

namespace asap::simulation {
namespace {

constexpr std::int64_t kSettlingBounds = 20;     // T_settle, in latency bounds ...
constexpr std::uint64_t kSettlingPackages = 60;  // ... and in packages

constexpr std::uint64_t kFirstPackages = 16;  // packages

struct Run {
  Setup setup;
  std::optional<LiveSetup> live{};
  std::vector<Fault> faults;
  Tally tally{};
};

// Pushed while the pipeline is shut: nobody counts it.
void lose_packets(Stream& stream, Draw& draw) {
  Packet packet;
  while (!stream.ended() && draw.chance(0.5)) stream.read(packet);
}

void run(Run& run, Journal& journal) {
  const Setup first = run.setup;
  Stream stream(first, run.faults);
  ConsumerCost cost(first, run.faults);
  Draw draw(first.seed, 8);
  World world{run.faults, stream, cost, draw, journal, run.tally, first.lag_ns};
  auto scheme = make_scheme(run.setup);
  std::vector<bool> changed(run.faults.size(), false);
  for (bool again = true; again;) {
    if (run.live) {
      LiveLife(run.setup, *run.live, *scheme, world).run();
      scheme = make_scheme(run.setup);  // the other one may have another bound by now
    } else {
      Life(run.setup, *scheme, world).run();
    }
    again = !stream.ended() && !journal.over();
    if (!again) return;
    lose_packets(stream, draw);
    for (std::size_t i = 0; i < run.faults.size(); ++i) {
      const bool is_due = run.faults[i].kind == FaultKind::reconfigure && world.over[i];
      if (!is_due || changed[i]) continue;
      changed[i] = true;
      reconfigure(run.setup, run.faults[i]);
      scheme = make_scheme(run.setup);
    }
  }
}

bool has(const std::vector<Fault>& faults, FaultKind kind) {
  return std::any_of(faults.begin(), faults.end(),
                     [kind](const Fault& fault) { return fault.kind == kind; });
}

// Whether enough calm has gone by for a judgement, and the setup is one whose loop must recover.
bool can_be_judged(const Run& run) {
  const Setup& setup = run.setup;
  const Tally& tally = run.tally;
  // Without gamma a backlog must drain: only where there is room for it.
  const bool drains = setup.scheme.kind <= Kind::greedy && setup.load() < 0.4 &&
                      setup.scheme.kind != Kind::single_event &&
                      setup.scheme.kind != Kind::fixed_size && setup.scheme.efficiency == 0;
  if (!setup.keeps_a_bound() && !drains) return false;
  if (has(run.faults, FaultKind::reconfigure) || has(run.faults, FaultKind::odd_ring)) return false;
  const double per_bound = static_cast<double>(setup.latency_ns) / setup.gap_ns;
  if (static_cast<double>(setup.capacity) < 16 * per_bound) return false;
  // A bound of a few events is a matter of luck, the more so for a whole package: where the filter
  // keeps two of seven too many, nothing stops it.
  const double few = setup.execution == Execution::whole ? 40 : 20;
  if (few * setup.beta_ns > static_cast<double>(setup.latency_ns)) return false;
  // What a cost model has learned in the first packages, or in the few after a change of level, it
  // keeps for long: a weakness that is known.
  if (tally.odd_package < kFirstPackages) return false;
  if (tally.odd_package != kNoPackage && tally.odd_packages < 2 * kFirstPackages) return false;
  if (tally.calm_ns == kNever || tally.judged_start_ns == kNever) return false;
  return tally.judged_rejected == 0 && setup.flush &&
         tally.judged_start_ns - tally.calm_ns > kSettlingBounds * setup.latency_ns &&
         tally.judged_package > tally.calm_package + kSettlingPackages;
}

double kept(const Tally& tally) {
  return static_cast<double>(tally.judged_kept) /
         static_cast<double>(std::max<std::uint64_t>(tally.judged, 1));
}

void hold_recovery(const Run& run, const Run& twin, Journal& journal) {
  const auto bound_ns = static_cast<double>(run.setup.latency_ns);
  const auto calm_ns = static_cast<double>(twin.tally.judged_latency_ns);
  const auto latency_ns = static_cast<double>(run.tally.judged_latency_ns);
  const double limit_ns = std::max(bound_ns, calm_ns) * 1.1 + 0.1 * bound_ns;
  journal.hold(Law::liveness, latency_ns <= limit_ns, "largest latency after the faults",
               latency_ns, limit_ns);
  const double min = kept(twin.tally) - 0.1;
  journal.hold(Law::liveness, kept(run.tally) >= min, "kept after the faults", kept(run.tally),
               min);
}

Run draw_run(const TrialConfig& config) {
  Run run{.setup = draw_setup(config.seed), .faults = {}};
  run.faults = draw_faults(run.setup, config.faults);
  configure(run.setup, run.faults);
  if (config.live) run.live = draw_live(run.setup);
  return run;
}

std::string text(const Run& run) {
  return text(run.setup) + (run.live ? text(*run.live) : "") + text(run.faults);
}

}  // namespace

TrialResult run_trial(const TrialConfig& config) {
  Run faulty = draw_run(config);
  const std::string drawn = text(faulty);
  Sha256 hash;
  if (config.fingerprint) faulty.tally.fingerprint = &hash;
  Journal journal(config.until);
  run(faulty, journal);
  TrialResult result{.seed = config.seed};
  result.events = faulty.tally.received;
  result.packages = faulty.tally.packages;
  if (config.live) {
    result.judged = faulty.tally.judged > 0;
  } else if (!journal.over() && !faulty.faults.empty() && can_be_judged(faulty)) {
    Run twin{.setup = faulty.setup, .faults = {}};
    Journal calm(kToTheEnd);
    run(twin, calm);
    result.judged = !calm.failed();
    result.events += twin.tally.received;
    result.packages += twin.tally.packages;
    if (result.judged) hold_recovery(faulty, twin, journal);
  }
  result.steps = journal.steps();
  if (config.fingerprint) result.fingerprint = hash.finish();
  result.failed = journal.failed();
  result.law = static_cast<int>(journal.law());
  if (result.failed || config.until != kToTheEnd) {
    result.report = drawn;
    if (result.failed) result.report += "  " + journal.violation() + "\n";
    result.report += journal.last_steps();
  }
  return result;
}

std::string describe(const TrialConfig& config) { return text(draw_run(config)); }

}  // namespace asap::simulation
