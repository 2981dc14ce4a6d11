"""The simulator is believed only where it is checked: real time beside virtual time.

The same stream goes through the same scheme twice: replayed in real time into an algorithm that
spins for a known cost (`BusyWait`), and simulated with that cost. What differs is the machine.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from asap import _core
from asap.experiment import Run, run, simulate
from asap_laboratory import _native
from asap_laboratory.profiles import Profile

PROFILES = ("low", "uav", "flicker", "steps", "bursts", "high")


@dataclass(frozen=True)
class Pair:
    """One stream in both clocks."""

    profile: str
    real: Run
    virtual: Run


def scheduling_jitter(duration_s: float = 1.0) -> _core.LatencyHistogram:
    """Measure how long this machine takes the processor away from a thread.

    Parameters
    ----------
    duration_s : float
        How long to look, s.

    Returns
    -------
    LatencyHistogram
        Times between two looks at the clock of a thread that does nothing else, us.
    """
    return _core.LatencyHistogram(_native.scheduling_jitter(duration_s))


def replay_beside_simulation(
    profiles: Sequence[str] = PROFILES,
    *,
    alpha_us: float = 100.0,
    beta_ns: float = 300.0,
    latency_ms: float = 10.0,
    duration_s: float = 2.0,
    seed: int = 1,
) -> list[Pair]:
    """Run each profile in both clocks.

    Parameters
    ----------
    profiles : sequence of str
        Names of `asap_laboratory.profiles.PROFILES`.
    alpha_us, beta_ns : float
        Cost of the algorithm, spun and simulated.
    latency_ms : float
        Bound of the scheme, a Deadline.
    duration_s : float
        Of each stream; so long takes the real one.
    seed : int
        Of the arrivals and of the gamma filter.
    """
    pairs = []
    for profile in profiles:
        events = Profile(profile, duration_s=duration_s, seed=seed).events()
        options: dict[str, Any] = {"latency_ms": latency_ms, "seed": seed}
        cost = _core.LinearCost(alpha_us, beta_ns)
        pairs.append(
            Pair(
                profile,
                run(events, algorithm=_native.BusyWait(alpha_us, beta_ns), **options),
                simulate(events, cost=cost, **options),
            )
        )
    return pairs


def format_pairs(pairs: Sequence[Pair], jitter: _core.LatencyHistogram) -> str:
    """Write the pairs as a Markdown table; every cell reads real / virtual, latencies in ms."""
    lines = [
        "| profile | kept | in time | p50 | p99 | max | producer late, p99 / max |",
        "|---|---|---|---|---|---|---|",
    ]
    for pair in pairs:
        both = (pair.real, pair.virtual)
        cells = [
            " / ".join(f"{one.kept:.3f}" for one in both),
            " / ".join(f"{one.in_time:.3f}" for one in both),
            *(" / ".join(_ms(one.latency.quantile(q)) for one in both) for q in (0.5, 0.99)),
            " / ".join(_ms(one.latency.max) for one in both),
        ]
        late = pair.real.lateness
        cells.append("" if late is None else f"{_ms(late.quantile(0.99))} / {_ms(late.max)}")
        lines.append(f"| {pair.profile} | {' | '.join(cells)} |")
    lines += [
        "",
        "Scheduling jitter of the machine: a thread that does nothing but look at the clock "
        f"misses {_ms(jitter.max)} ms at most and {_ms(jitter.quantile(0.99999))} ms at p99.999.",
    ]
    return "\n".join(lines)


def as_json(pairs: Sequence[Pair]) -> list[dict[str, Any]]:
    """Both summaries of each pair."""
    return [
        {"profile": pair.profile, "real": pair.real.summary(), "virtual": pair.virtual.summary()}
        for pair in pairs
    ]


def _ms(time_us: float) -> str:
    return f"{time_us / 1e3:.2f}"
