"""The reference study's figures, to be put beside ours: lookups, aggregates, and after steps.

Means of three seeds of 5 s, a fluid simulation in bins of 2 us that was made before this code. What
it called "Deadline L/2" and "Deadline auto" is `DeadBeat`; its reservoir law is `Deadline`. Its
best rows choose their parameters per profile with hindsight.
"""

from __future__ import annotations

from functools import cache

from asap.study.reference_profiles import FURTHER_SCORES, PER_PROFILE

__all__ = ["aggregate", "per_profile", "step"]

_AGGREGATE = {
    "mean": """
        | fast slow slow_tv slow_ht
        FixedSize 1000 | .675 .224 .223 .257
        FixedSize 5000 | .618 .264 .145 .223
        FixedTime 1 ms | .896 .385 .249 .303
        FixedTime 20 ms | .032 .115 .078 .083
        SingleEvent | .111 .111 0 0
        Asap2020 best | .957 .747 .563 .586
        Asap2022 | .37 .019 .091 .018
        Asap2022 best | .796 .5 .439 .309
        Spark PID | .985 .879 .81 .496
        Clipper AIMD | .897 .473 .302 .379
        Greedy | .897 .476 .294 .39
        greedy+PIE | .928 .587 .623 .551
        greedy+clear | .992 .765 .776 .696
        jAER timer | .998 .98 .975 .926
        greedy+rate-gamma | .949 .824 .682 .725
        opaque DeadBeat | .998 .975 .959 .823
        DeadBeat L/2 | .998 .98 .975 .953
        DeadBeat | .997 .969 .962 .944
        DeadBeat oh.25 | .997 .966 .959 .94
        DeadBeat 1kHz | .997 .966 .953 .94
        """,
    "least": """
        | fast slow slow_tv slow_ht
        FixedSize 1000 | .005 .002 .002 .001
        FixedSize 5000 | .001 .002 .002 .002
        FixedTime 1 ms | .064 .002 .002 .001
        FixedTime 20 ms | 0 0 0 0
        SingleEvent | 0 0 0 0
        Asap2020 best | .793 .288 .265 .165
        Asap2022 | 0 .003 .009 .001
        Asap2022 best | .07 .029 .118 .045
        Spark PID | .907 .565 .615 .149
        Clipper AIMD | .071 .002 .002 .001
        Greedy | .072 .001 .002 .001
        greedy+PIE | .352 .002 .154 .083
        greedy+clear | .927 .476 .497 .442
        jAER timer | .985 .886 .885 .821
        greedy+rate-gamma | .538 .466 .257 .488
        opaque DeadBeat | .979 .867 .854 .705
        DeadBeat L/2 | .984 .883 .888 .862
        DeadBeat | .975 .838 .834 .809
        DeadBeat oh.25 | .976 .812 .824 .814
        DeadBeat 1kHz | .974 .824 .788 .823
        """,
    "p99_of_bound": """
        | fast slow slow_tv slow_ht
        FixedSize 1000 | 252 50.5 75.4 46
        FixedSize 5000 | 1253 251 68 38.1
        FixedTime 1 ms | 10.9 35.1 68.7 39.1
        FixedTime 20 ms | 20.7 34 65.6 45.2
        SingleEvent | 10466 10492 10492 10492
        Asap2020 best | 227 45.4 8.13 17.1
        Asap2022 | 227 196 30.4 121
        Asap2022 best | 227 45.4 57 40.6
        Spark PID | 1.07 8.68 8.92 10.5
        Clipper AIMD | 11 32.7 59.2 38
        Greedy | 10.7 33.4 61.9 64.5
        greedy+PIE | 2.75 18.8 13.4 12.4
        greedy+clear | 1.08 8.44 8.85 7.45
        jAER timer | .992 .995 .995 1.5
        greedy+rate-gamma | 2.71 3.05 35.6 15.1
        opaque DeadBeat | .963 .975 .982 1.42
        DeadBeat L/2 | .992 .995 .995 .998
        DeadBeat | .789 .815 .988 .995
        DeadBeat oh.25 | .794 .804 .988 .995
        DeadBeat 1kHz | .992 .826 .988 .995
        """,
    "cpu": """
        | fast slow slow_tv slow_ht
        FixedSize 1000 | .2 .74 .82 .81
        FixedSize 5000 | .15 .71 .79 .77
        FixedTime 1 ms | .15 .75 .82 .81
        FixedTime 20 ms | .1 .69 .77 .74
        SingleEvent | .89 .91 1 1
        Asap2020 best | .69 .72 .79 .71
        Asap2022 | .5 .3 .29 .58
        Asap2022 best | .28 .62 .61 .62
        Spark PID | .15 .53 .56 .55
        Clipper AIMD | .84 .91 1 1
        Greedy | .84 .91 1 1
        greedy+PIE | .84 .91 1 1
        greedy+clear | .84 .91 1 1
        jAER timer | .84 .91 1 1
        greedy+rate-gamma | .84 .91 1 1
        opaque DeadBeat | .84 .91 1 1
        DeadBeat L/2 | .84 .91 1 1
        DeadBeat | .84 .91 1 1
        DeadBeat oh.25 | .34 .69 .72 .71
        DeadBeat 1kHz | .15 .62 .65 .63
        """,
}

_DEADLINE = {"slow": 0.990, "fast": 0.998, "slow_tv": 0.986, "slow_ht": 0.962}  # mean scores, 12.9

_STEP = {
    "slow": """
        | p50_ms p99_ms max_ms kept score overflow packages_per_s cpu gap_ms settle_ms
        FixedSize 1000 | 260 419 420 .778 .044 .221 2436 .98 0 496
        FixedTime 1 ms | 193 337 338 .881 .06 .119 998 .93 1 496
        Asap2020 best | 1.4 4.26 30.7 .462 .791 0 4619 .9 0 100
        Asap2022 | 25.9 285 430 .194 .011 0 21 .18 0 496
        Asap2022 best | 35.9 165 170 .615 .171 0 330 .61 0 496
        Spark PID | 7.63 10.7 11.9 .563 .895 0 200 .55 0 411
        Clipper AIMD | 172 324 327 .826 .066 .109 2193 1 163 496
        Greedy | 209 319 329 .732 .082 .248 3211 1 119 496
        greedy+PIE | 10.6 15.1 17.1 .575 .409 0 4537 1 0 496
        greedy+clear | 5.55 13.5 16 .556 .823 0 4714 1 11 496
        jAER timer | 8.48 9.95 10 .574 .983 0 4567 1 2 496
        greedy+rate-gamma | 8.02 13.1 15.1 .572 .78 0 4564 1 0 442
        opaque DeadBeat | 6.66 9.72 10.5 .57 .976 0 4577 1 0 0
        DeadBeat L/2 | 7.23 9.95 10 .574 .983 0 4566 1 0 0
        DeadBeat | 4.84 6.75 9.85 .566 .97 0 4630 1 0 0
        DeadBeat oh.25 | 4.83 6.77 10 .565 .968 0 1390 .67 0 0
        DeadBeat 1kHz | 4.83 6.7 9.88 .565 .968 0 649 .6 0 0
        """,
    "slow_ht": """
        | p50_ms p99_ms max_ms kept score gap_ms settle_ms
        FixedSize 1000 | 270 448 453 .769 .032 16 496
        FixedTime 1 ms | 201 353 361 .872 .043 13 496
        Asap2020 best | 1.5 41.7 147 .403 .521 0 255
        Asap2022 | 20.1 237 449 .262 .047 0 496
        Asap2022 best | 17.8 154 331 .458 .096 0 496
        Spark PID | 13.1 47.4 54.5 .553 .247 0 496
        Clipper AIMD | 179 361 373 .811 .056 162 496
        Greedy | 185 487 504 .72 .067 287 496
        greedy+PIE | 8.71 27.7 40.9 .561 .456 0 486
        greedy+clear | 4.51 19.5 27.4 .543 .648 25 496
        jAER timer | 7.83 13.8 28.5 .662 .887 19 486
        greedy+rate-gamma | 2.91 52 69.2 .537 .658 0 413
        opaque DeadBeat | 4.26 12.8 25.2 .553 .748 16 443
        DeadBeat L/2 | 6.68 9.95 25.6 .657 .917 14 162
        DeadBeat | 5.6 9.59 23.9 .66 .921 15 126
        DeadBeat oh.25 | 5.74 9.66 25.8 .646 .902 15 132
        DeadBeat 1kHz | 6.02 9.78 24.5 .649 .907 14 125
        """,
}


def per_profile(quantity: str, cost_model: str, contender: str, profile: str) -> float | None:
    """Return score, kept, p99_ms, p50_ms, cpu or packages_per_s of a run; None: not reported."""
    found = _rows(PER_PROFILE.get((cost_model, quantity), "")).get(contender, {}).get(profile)
    if found is None and quantity == "score":
        further = _rows(FURTHER_SCORES.get(cost_model, ""))
        return further.get(profile, {}).get(contender)
    return found


def aggregate(quantity: str, cost_model: str, contender: str) -> float | None:
    """Return the mean or least score, the worst p99 / L or the mean CPU over the named profiles."""
    if (quantity, contender) == ("mean", "Deadline"):
        return _DEADLINE.get(cost_model)
    return _rows(_AGGREGATE[quantity]).get(contender, {}).get(cost_model)


def step(quantity: str, cost_model: str, contender: str) -> float | None:
    """Return a quantity of the abrupt step in detail: profile steps with slow or slow_ht."""
    return _rows(_STEP.get(cost_model, "")).get(contender, {}).get(quantity)


@cache
def _rows(text: str) -> dict[str, dict[str, float]]:
    header, *lines = text.strip().splitlines() or [""]
    columns = [
        name.replace("_timer", " timer").replace("_L/2", " L/2") for name in header.split()[1:]
    ]
    rows = {}
    for line in lines:
        name, _, numbers = line.partition(" | ")
        values = (float(number) for number in numbers.split())
        rows[name.strip()] = dict(zip(columns, values, strict=True))
    return rows
