"""What a tracker got wrong on a recording, in words: the most frequent first."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np

from asap_laboratory.rivals.recordings import Followed
from asap_laboratory.scoring.boxes import PADDING_PX, BoxMatch

_MAX_IDS = 6  # false ids that are named
_MAX_SPANS = 3  # of an object's misses that are named


class Span(NamedTuple):
    """Labelled times that follow each other: first and last of them."""

    first: int
    last: int

    @property
    def size(self) -> int:
        """How many there are."""
        return self.last - self.first + 1


def spans(indices: Iterable[int]) -> list[Span]:
    """Put ascending indices that follow each other together."""
    found: list[Span] = []
    for index in indices:
        if found and found[-1].last + 1 == index:
            found[-1] = found[-1]._replace(last=index)
        else:
            found.append(Span(index, index))
    return found


def mistakes(followed: Followed) -> list[str]:
    """Say which objects were missed and when, which ids changed, which clusters were false."""
    return [*_misses(followed), *_switches(followed), *_false(followed)]


def _misses(followed: Followed) -> Iterator[str]:
    missed: defaultdict[int, list[int]] = defaultdict(list)
    life: defaultdict[int, int] = defaultdict(int)
    for index, one in enumerate(followed.matches):
        matched = {row for row, _ in one.pairs}
        for row, label in enumerate(one.frame["id"].tolist()):
            life[label] += 1
            if row not in matched:
                missed[label].append(index)
    for label in sorted(missed, key=lambda label: -len(missed[label])):
        longest = sorted(spans(missed[label]), key=lambda span: -span.size)
        when = ", ".join(_when(followed, span) for span in sorted(longest[:_MAX_SPANS]))
        more = " and shorter gaps" if len(longest) > _MAX_SPANS else ""
        often = f"at {len(missed[label])} of {life[label]} times"
        yield f"object {label} is missed {often}, {when}{more}"


def _switches(followed: Followed) -> Iterator[str]:
    last: dict[int, int] = {}
    for index, one in enumerate(followed.matches):
        for row, column in one.pairs:
            label, id = int(one.frame["id"][row]), int(one.found.ids[column])
            if row in one.switched:
                when = f"{followed.times_s[index]:.2f} s"
                yield f"object {label} changes from id {last[label]} to id {id} at {when}"
            last[label] = id


def _false(followed: Followed) -> Iterator[str]:
    if not followed.scene.background_labelled:
        return
    seen: defaultdict[int, list[tuple[int, int]]] = defaultdict(list)  # by id: time, row
    for index, one in enumerate(followed.matches):
        for row in one.false:
            seen[int(one.found.ids[row])].append((index, row))
    often = sorted(seen, key=lambda id: -len(seen[id]))
    for id in often[:_MAX_IDS]:
        first, last = seen[id][0][0], seen[id][-1][0]
        places = [followed.matches[index].found.positions[row] for index, row in seen[id]]
        x, y = np.median(places, axis=0)
        where = _where([_box_around(followed.matches[index], row) for index, row in seen[id]])
        when = f"{_times(len(seen[id]))}, {_when(followed, Span(first, last))}"
        yield f"id {id} is false at {when}, near ({x:.0f}, {y:.0f}): {where}"
    if rest := often[_MAX_IDS:]:
        times = _times(sum(len(seen[id]) for id in rest))
        yield f"{len(rest)} more id{'s are' if len(rest) > 1 else ' is'} false, at {times}"


def _times(count: int) -> str:
    return f"{count} time{'s' * (count != 1)}"


def _box_around(match: BoxMatch, row: int) -> int | None:
    """Object in whose box a cluster lies, if any."""
    x, y = match.found.positions[row]
    for label, left, top, w, h in match.frame[["id", "x", "y", "w", "h"]].tolist():
        across = left - PADDING_PX <= x <= left + w + PADDING_PX
        if across and top - PADDING_PX <= y <= top + h + PADDING_PX:
            return int(label)
    return None


def _where(boxes: list[int | None]) -> str:
    inside = [label for label in boxes if label is not None]
    if 2 * len(inside) < len(boxes):
        return "off every box"
    return f"a second cluster in the box of object {max(set(inside), key=inside.count)}"


def _when(followed: Followed, span: Span) -> str:
    times_s = followed.times_s
    first, last = f"{times_s[span.first]:.2f}", f"{times_s[span.last]:.2f}"
    return f"at {first} s" if first == last else f"between {first} and {last} s"
