#include "scheme_laws.hpp"

#include <algorithm>
#include <cmath>

namespace asap::simulation {
namespace {

void hold_same(const Decision& decision, const Decision& wanted, Journal& journal) {
  journal.hold(Law::size, decision.takes == wanted.takes, "takes", decision.takes, wanted.takes);
  if (!wanted.takes) {
    journal.equal(Law::size, decision.until_count, wanted.until_count, "waits for events");
    journal.equal(Law::age, decision.until_ns, wanted.until_ns, "waits until");
    return;
  }
  journal.equal(Law::size, decision.raw, wanted.raw, "raw events taken");
  journal.equal(Law::gamma, decision.gamma, wanted.gamma, "fraction to keep");
}

Decision fixed_time(const Backlog& backlog, std::int64_t period_ns) {
  std::int64_t boundary_ns = backlog.oldest_ns - backlog.oldest_ns % period_ns;
  if (boundary_ns <= backlog.oldest_ns) boundary_ns += period_ns;
  if (backlog.now_ns < boundary_ns && !backlog.due) return Decision::wait_until(boundary_ns);
  return Decision::take(backlog.counts.before(boundary_ns));
}

void hold_paper(const SchemeSetup& scheme, const Backlog& backlog, const Decision& decision,
                Journal& journal) {
  if (!decision.takes) return;
  const double open = scheme.kind == Kind::asap2022 ? 1000 : 0;  // a container
  const double max = open + std::ceil(static_cast<double>(scheme.max_size) / 0.02);
  journal.hold(Law::size, static_cast<double>(decision.raw) <= max, "raw events taken",
               static_cast<double>(decision.raw), max);
  const std::size_t min = std::min(scheme.size, backlog.count);
  if (scheme.kind == Kind::asap2020) {
    journal.hold(Law::size, backlog.due || decision.raw >= min, "raw events taken, not due",
                 static_cast<double>(decision.raw), static_cast<double>(min));
  }
}

void hold_bounded(const Setup& setup, const Backlog& backlog, const Decision& decision,
                  Journal& journal) {
  const auto bound_ns = static_cast<double>(setup.latency_ns);
  if (!decision.takes) {
    // Deadline plans with a longer bound where this one is beyond its means.
    if (setup.scheme.kind == Kind::deadline) return;
    const double until_ns = static_cast<double>(decision.until_ns - backlog.oldest_ns);
    journal.hold(Law::age, until_ns <= bound_ns / 2 + 1, "waits until the oldest is", until_ns,
                 bound_ns / 2);
    return;
  }
  if (decision.raw == 0) return;
  const bool is_anytime = setup.execution == Execution::anytime;
  const bool is_timed = is_anytime || setup.scheme.kind == Kind::deadline;
  journal.hold(Law::protocol, is_timed == (decision.budget_ns != kNever), "has a budget");
  journal.hold(Law::protocol, decision.budget_ns > 0, "budget > 0",
               static_cast<double>(decision.budget_ns));
  const double event_ns = decision.event_ns;
  journal.hold(Law::protocol, std::isfinite(event_ns) && (!is_anytime || event_ns > 0),
               "cost of an event", event_ns);
  journal.hold(Law::protocol, !is_anytime || decision.max_event_ns >= event_ns,
               "the most that an event costs", decision.max_event_ns);
  journal.hold(Law::protocol, std::isfinite(decision.fixed_ns) && decision.fixed_ns >= 0,
               "fixed cost", decision.fixed_ns);
}

}  // namespace

void hold_decision(const Setup& setup, const Backlog& backlog, const Decision& decision,
                   Journal& journal) {
  const SchemeSetup& scheme = setup.scheme;
  if (scheme.kind == Kind::hostile) return;
  journal.hold(Law::age, decision.takes || !backlog.due, "waits, though it is due");
  if (decision.takes) {
    journal.hold(Law::size, decision.raw + decision.stale > 0, "takes nothing");
    journal.hold(Law::size, decision.raw + decision.stale <= backlog.count, "takes more than waits",
                 static_cast<double>(decision.raw), static_cast<double>(backlog.count));
    journal.hold(Law::gamma, decision.gamma >= scheme.min_gamma * (1 - 1e-9) || decision.raw == 0,
                 "fraction to keep", decision.gamma, scheme.min_gamma);
    journal.hold(Law::gamma, decision.gamma <= 1, "fraction to keep", decision.gamma, 1);
  }
  switch (scheme.kind) {
    case Kind::fixed_size: {
      const bool waits = backlog.count < scheme.size && !backlog.due;
      return hold_same(decision,
                       waits ? Decision::wait_for(scheme.size)
                             : Decision::take(std::min(backlog.count, scheme.size)),
                       journal);
    }
    case Kind::fixed_time:
      return hold_same(decision, fixed_time(backlog, scheme.period_ns), journal);
    case Kind::single_event:
      return hold_same(decision, Decision::take(1), journal);
    case Kind::greedy:
      if (scheme.efficiency > 0) return;
      return hold_same(decision, Decision::take(backlog.count), journal);
    case Kind::asap2020:
    case Kind::asap2022:
      return hold_paper(scheme, backlog, decision, journal);
    case Kind::deadline:
    case Kind::dead_beat:
      return hold_bounded(setup, backlog, decision, journal);
    case Kind::hostile:
      return;
  }
}

}  // namespace asap::simulation
