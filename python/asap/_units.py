"""Numbers with units: read from the command line, written for a reader."""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Mapping, Sequence

_NS_PER_UNIT = {"ns": 1, "us": 10**3, "µs": 10**3, "ms": 10**6, "s": 10**9}
_NUMBER_AND_UNIT = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?)\s*([^\W\d]*)\s*")


def parse_duration_us(text: str, *, field: str = "duration") -> float:
    """Microseconds of a duration with its unit, such as ``"10ms"``: finite and not negative."""
    return _parse_ns(text, field) / 1e3


def parse_cost(text: str, *, field: str = "cost") -> tuple[float, float]:
    """Read ``"100us+300ns"``: time per package in us, and per event in ns."""
    # A plus sign inside a number follows its "e".
    terms = re.split(r"(?<![eE])\+", text)
    if len(terms) != 2:
        raise _error(field, text, "write time per package + time per event, such as 100us+300ns")
    alpha_us = parse_duration_us(terms[0], field=f"{field}, per package")
    return alpha_us, _parse_ns(terms[1], f"{field}, per event")


def duration(value_us: float) -> str:
    """Write microseconds with at most three digits and a fitting unit, such as ``"4.21 ms"``."""
    for unit, size_us in (("s", 1e6), ("ms", 1e3), ("us", 1.0)):
        if abs(value_us) >= 0.9995 * size_us:
            return f"{_three_digits(value_us / size_us)} {unit}"
    return f"{_three_digits(value_us * 1e3)} ns" if value_us else "0 us"


def rate(value_hz: float) -> str:
    """Write events per second with at most three digits, such as ``"6.53 Mev/s"``."""
    for prefix, size in (("G", 1e9), ("M", 1e6), ("k", 1e3)):
        if abs(value_hz) >= 0.9995 * size:
            return f"{_three_digits(value_hz / size)} {prefix}ev/s"
    return f"{_three_digits(value_hz)} ev/s"


def rate_axis(peak_hz: float) -> tuple[str, float]:
    """Choose the unit of an axis up to a rate; events per second times the second are in it."""
    return ("Mev/s", 1e-6) if peak_hz >= 1e6 else ("kev/s", 1e-3)


def count(value: float) -> str:
    """Write a whole number in groups of three digits, such as ``"27,300,000"``."""
    return f"{round(value):,}"


def reasons(counts: Mapping[str, int]) -> str:
    """Write the counts that are not zero, such as ``"1,200 nonmonotonic, 3 out_of_bounds"``."""
    return ", ".join(f"{count(some)} {name}" for name, some in counts.items() if some)


def share(value: float) -> str:
    """Write a fraction in percent, "-" for that of nothing (nan).

    Neither 0 nor 100 % is ever shown for less or more than that.
    """
    if math.isnan(value):
        return "-"
    percent = 100 * value
    if 0 < percent < 0.1:
        return "< 0.1 %"
    if 99.9 < percent < 100:
        return "> 99.9 %"
    return f"{percent:.1f} %"


def score(value: float) -> str:
    """Write a share with three digits, "-" for that of nothing (nan)."""
    return "-" if math.isnan(value) else f"{value:.3f}"


def tied(text: str) -> str:
    """Put a no-break space between every number and its unit."""
    return re.sub(r"(?<=[\d<>]) (?=\S)|(?<=\+-) ", "\xa0", text)


def wrapped(text: str, width: int, indent: int = 0) -> list[str]:
    """Break a text into lines, all but the first indented; a number stays beside its unit."""
    lines = textwrap.wrap(
        tied(text[indent:]),
        width,
        initial_indent=text[:indent],
        subsequent_indent=" " * indent,
        break_long_words=False,
        break_on_hyphens=False,
    )
    return [line.replace("\xa0", " ").rstrip() for line in lines or [text]]


def aligned(table: Sequence[Sequence[str]], left: int = 1) -> tuple[list[str], str]:
    """Align the columns of a table, the first `left` of them to the left; its lines and a rule."""
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    lines = [
        "  ".join(
            text.ljust(width) if at < left else text.rjust(width)
            for at, (text, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in table
    ]
    return lines, "-" * (sum(widths) + 2 * len(widths) - 2)


def _parse_ns(text: str, field: str) -> float:
    match = _NUMBER_AND_UNIT.fullmatch(text)
    if match is None:
        raise _error(field, text, "write a number and its unit, such as 10ms")
    number, unit = match.groups()
    if not unit:
        raise _error(field, text, f"the unit is missing, for example {number}ms or {number}us")
    if unit not in _NS_PER_UNIT:
        raise _error(field, text, f"unknown unit {unit!r}, use one of ns, us, ms, s")
    value_ns = float(number) * _NS_PER_UNIT[unit]
    if not (math.isfinite(value_ns) and value_ns >= 0):
        raise _error(field, text, "must be finite and not negative")
    return value_ns


def _three_digits(value: float) -> str:
    return f"{value:,.0f}" if abs(value) >= 999.5 else f"{value:.3g}"


def _error(field: str, value: str, remedy: str) -> ValueError:
    return ValueError(f"{field} = {value}: {remedy}")
