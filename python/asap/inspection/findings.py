"""From what the meters show to verdicts: ok, note or wrong, in words and with a remedy."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from asap import _units
from asap.events.values import unit_doubt
from asap.inspection.meters import (
    ALONE_US,
    GAP_US,
    MAX_SIDE,
    BadEvents,
    Meters,
    PixelMap,
    Steps,
    Tally,
)
from asap.inspection.raw_source import RawSource
from asap.inspection.result import NOTE, OK, WRONG, Finding

WRONG_GAP_US = 1_000_000  # so far ahead is as odd as so far back, which is a clock reset
# Shares of the good events.
NOISE = 0.5  # without a neighbour; sound recordings have up to 0.45
ALL_NOISE = 0.9  # of the share that events at random would have; sound recordings have up to 0.7
WRONG_HOT = 0.1
MAX_LATE = 4  # late events per one that a run drops: of two packets that changed places
ENOUGH = 100  # events, to expect both polarities

_FAR = 0.1  # of the duration: if most events are later, one timestamp before them is wrong
_COUNTER_BITS = (23, 24, 30, 31, 32)  # counters of cameras and formats, in us


def judge(raw: RawSource, bad: BadEvents, meters: Meters) -> Iterator[Finding]:
    """Judge every check, once the source has been read."""
    yield _empty(bad, meters, raw)
    yield _records(raw, bad)
    yield _truncated(raw)
    yield _out_of_bounds(raw, bad, meters.pixels)
    yield _found(
        "back_steps",
        WRONG,
        bad.back_steps,
        _disorder_words(bad),
        f"A run drops and counts them. {_sorting(bad, meters)}",
    )
    yield _lost(raw)
    yield _found(
        "clock_resets",
        WRONG,
        bad.clock_resets,
        _reset_words(bad),
        "Timestamps before and after are of two clocks: split the recording there. A run goes on "
        "1 us after the last event.",
    )
    yield _gaps(meters.steps)
    yield _time_unit(raw, meters)
    yield _polarity(bad, meters)
    yield _noise(meters)
    yield _hot_pixels(meters)


def _found(
    name: str,
    verdict: str,
    found: Tally | int,
    detail: str,
    remedy: str,
    *,
    byte: int | None = None,
) -> Finding:
    """Make a finding; what was never found is ok."""
    tally = found if isinstance(found, Tally) else Tally(found)
    if tally.count == 0:
        return Finding(name, 0, OK, detail)
    return Finding(name, tally.count, verdict, detail, remedy, tally.event, tally.t_us, byte)


def _empty(bad: BadEvents, meters: Meters, raw: RawSource) -> Finding:
    if meters.events:
        return Finding("empty", 0, OK, f"{_units.count(meters.events)} good events")
    if bad.seen + raw.losses.bad_record + raw.losses.out_of_bounds == 0:
        if raw.losses.cut is not None:
            words = "nothing before the end of the file can be read"
            return Finding("empty", 1, WRONG, words, "Copy the file again.")
        return Finding("empty", 1, NOTE, "no events", "Nothing was recorded, or not written.")
    return Finding("empty", 1, WRONG, "not one good event", "See the other checks.")


def _records(raw: RawSource, bad: BadEvents) -> Finding:
    losses = raw.losses
    found = replace(bad.unreadable, count=losses.bad_record + bad.unreadable.count)
    detail = "records that are no events, or whose timestamps are no times"
    remedy = "Are order and time unit right? Else the file is damaged there."
    if 2 * losses.between_pixels > found.count:
        detail = "x and y lie between pixels"
        remedy = (
            "asap.read(..., on_bad='clamp'), on the command line --on-bad clamp, moves each to the "
            "nearest pixel."
        )
    detail *= found.count > 0
    byte = next(iter(losses.bad_offsets), None)
    remedy = f"A run drops and counts them. {remedy}"
    return _found("bad_records", WRONG, found, detail, remedy, byte=byte)


def _truncated(raw: RawSource) -> Finding:
    fault, byte = ("", None) if (cut := raw.losses.cut) is None else (cut.fault, cut.offset)
    remedy = (
        "What stands before is read. Copy the file again; a recording that was never closed lost "
        "its end."
    )
    return _found("truncated", WRONG, int(cut is not None), fault, remedy, byte=byte)


def _out_of_bounds(raw: RawSource, bad: BadEvents, pixels: PixelMap) -> Finding:
    found = replace(bad.outside, count=raw.losses.out_of_bounds + bad.outside.count)
    known = bool(raw.width and raw.height)
    sensor = f"{raw.width} x {raw.height} px" if known else "sensor unknown: not checked"
    if found.count or known:
        remedy = (
            "A run drops and counts them. Many: is the sensor's size right, are x and y swapped? "
            "A few: transmission errors."
        )
        return _found("out_of_bounds", WRONG, found, sensor, remedy)
    rows, columns = pixels.counts.shape
    reach = f"addresses up to x = {columns - 1}, y = {rows - 1}"
    if pixels.beyond:
        reach = f"{_units.count(pixels.beyond)} events beyond {MAX_SIDE} px"
    remedy = "Say the size: width=, height= (--width, --height)."
    return Finding("out_of_bounds", 0, NOTE, f"{sensor}; {reach}", remedy)


def _is_disorder(bad: BadEvents) -> bool:
    """Whether events are out of place; else few stamps are wrong, and many look late for them."""
    return bad.late <= MAX_LATE * bad.back_steps.count


def _disorder_words(bad: BadEvents) -> str:
    if bad.back_steps.count == 0:
        return ""
    if not _is_disorder(bad):
        return f"largest {_units.duration(bad.largest_back_step_us)}"
    late = f"{_units.count(bad.late)} event{'s' * (bad.late > 1)} late"
    return f"{late}, largest {_units.duration(bad.latest_us)}"


def _sorting(bad: BadEvents, meters: Meters) -> str:
    """Name the tolerance that sorts events that are out of place; none repairs a wrong clock."""
    is_far = bad.latest_us > _FAR * meters.duration_us
    if not _is_disorder(bad) or (is_far and bad.back_steps.count >= meters.events):
        return "The timestamps of these are wrong, not their places: no sorting repairs them."
    depth_us = bad.latest_us
    return (
        f"asap.read(..., reorder_tolerance_us={depth_us}) sorts them into their place, on the "
        f"command line --reorder-tolerance {depth_us}us."
    )


def _lost(raw: RawSource) -> Finding:
    count = raw.losses.lost_packets
    words = f"{_units.count(count)} packets never arrived, as their numbers say" * (count > 0)
    remedy = "Nothing is decoded across a gap. Give the recorder a longer queue or a faster disk."
    return _found("lost_packets", WRONG, count, words, remedy)


def _reset_words(bad: BadEvents) -> str:
    if bad.clock_resets.count == 0:
        return ""
    fall_us = bad.largest_reset_us
    words = f"back by {_units.duration(fall_us)}"
    bits = [bits for bits in _COUNTER_BITS if abs(fall_us - 2**bits) < 0.01 * 2**bits]
    return f"{words}, as a counter of {bits[0]} bits wraps" if bits else words


def _gaps(steps: Steps) -> Finding:
    verdict = WRONG if steps.longest_us >= WRONG_GAP_US else NOTE
    return _found(
        "gaps",
        verdict,
        steps.gaps,
        f"longest {_units.duration(steps.longest_us)}",
        f"No event for {_units.duration(GAP_US)} or more: a still scene behind a noise filter, or "
        "lost data. Compare with the driver's own counters.",
    )


def _time_unit(raw: RawSource, meters: Meters) -> Finding:
    steps_us = np.diff(meters.head)
    doubt = unit_doubt(raw.losses.guessed_unit, meters.events, meters.duration_us, steps_us)
    detail, remedy = doubt or ("", "")
    found = Tally(int(doubt is not None), 0, meters.first_stamp_us)
    return _found("time_unit", NOTE, found, detail, f"{remedy[:1].upper()}{remedy[1:]}.")


def _noise(meters: Meters) -> Finding:
    alone = meters.alone
    if alone is None:
        return Finding("noise", 0, OK, "not measured: the sensor is unknown")
    share = alone.count / max(meters.events, 1)
    words = f"{_units.share(share)} of the events without a neighbour within {ALONE_US // 1000} ms"
    if share < NOISE or meters.events < ENOUGH or meters.duration_us < 5 * ALONE_US:
        return Finding("noise", 0, OK, words)
    if share >= ALL_NOISE * alone.at_random(meters.events, meters.duration_us):
        words += ", as many as where all are noise"
    remedy = "Put asap.BackgroundActivityFilter in front (--before background), or raise the "
    return Finding("noise", alone.count, NOTE, words, remedy + "thresholds of the camera.")


def _polarity(bad: BadEvents, meters: Meters) -> Finding:
    tally, events, on = bad.odd_polarity, meters.events, meters.on
    share = f"{_units.share(on / events)} ON" if events else ""
    if tally.count == 0 and events >= ENOUGH and on in (0, events):
        return Finding(
            "polarity", 0, NOTE, share, "One polarity only: the other was lost, or never written."
        )
    return _found(
        "polarity",
        NOTE,
        tally,
        f"neither 0 nor 1; {share}" if tally.count else share,
        "Read as ON where it is above 0, else as OFF: right for -1 and 1. Other values: is this "
        "column the polarity?",
    )


def _hot_pixels(meters: Meters) -> Finding:
    hot = meters.pixels.hot()
    busiest = meters.pixels.busiest() if hot.size == 0 else hot
    share = int(busiest["events"].sum()) / max(meters.events, 1)
    where = ", ".join(f"({x}, {y})" for x, y, _ in hot[:3].tolist())
    more = f" and {hot.size - 3} more" if hot.size > 3 else ""
    words = f"{_units.share(share)} of the events: {where}{more}"
    remedy = (
        "Mask them in the camera, or put asap.BackgroundActivityFilter in front of the algorithm."
    )
    if hot.size == 0:
        words = f"the 10 busiest hold {_units.share(share)}"
    verdict = WRONG if share >= WRONG_HOT else NOTE
    return _found("hot_pixels", verdict, hot.size, words, remedy)
