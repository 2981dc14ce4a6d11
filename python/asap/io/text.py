"""Text: one event per line, ``t x y p`` or any other arrangement, decoded by the native core.

What the columns and the unit of time are is decided from the first lines, unless the user says it:

* columns: a header line with names (``t,x,y,p``, also after a ``#``), else four columns are
  ``t x y p``, and any other number of them needs `order`;
* unit: the header (``t_us``, ``time [s]``), else seconds if a time is written with a decimal
  point, else microseconds. The user is asked where times with a point are whole, or times without
  one all multiples of 1000;
* a first line of two numbers is the sensor's width and height.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import IO

import numpy as np

from asap import _core
from asap.events.columns import FIELD_NAMES, ROLES, check_order
from asap.events.values import Events, are_thousands, time_exponent
from asap.io.columns import check_polarity, first_us, row_before
from asap.io.errors import CorruptFile, unclear_unit
from asap.io.reader import Losses, Options

_HEAD = 1 << 14
_MAX = 1 << 24  # bytes of comments before the first line
_PIECE = 1 << 18
_SHORTEST = 6  # bytes of a line with three numbers
_NUMBER = re.compile(rb"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
_QUOTED = re.compile(rb"""(["'])\d[\d.]*\1""")
_SEPARATORS = re.compile(rb"[ \t,;\r]+")
_DECIMAL_COMMA = re.compile(rb"\d,\d+ *[;\t]|[;\t] *\d+,\d")
_TRUTHS = {b"True": b"1", b"true": b"1", b"False": b"0", b"false": b"0"}  # as pandas writes them
_SENSOR = re.compile(
    rb"(?:geometry|resolution|size|sensor)\W*(\d{1,5})\s*[x,; ]\s*(\d{1,5})\b"
    rb"|\bwidth\W*(\d{1,5})\b\W*height\W*(\d{1,5})\b"
    rb"|^[#%\s]*(\d{1,5})\s*x\s*(\d{1,5})\s*$"
    rb"|(?P<height>)\bheight\W*(\d{1,5})\b\W*width\W*(\d{1,5})\b",
    re.MULTILINE,
)
_SIDES = re.compile(rb"(\d+)[\s,;x]+(\d+)")
_UNIT = re.compile(r"[\W_]*(s|sec|seconds?|ms|us|µs|ns)[\W_]*")
_UNITS = {"s": "s", "sec": "s", "second": "s", "seconds": "s", "µs": "us"}


@dataclass(frozen=True)
class _Layout:
    order: str  # a letter per column, '-' for one that is skipped
    unit: str
    start: int  # byte of the first data line
    separator: bytes
    width: int | None
    height: int | None
    line_bytes: float  # length of a data line, about
    guessed: bool  # the unit
    between_pixels: bool  # x or y is mostly no whole number


class TextReader:
    """Lines of numbers; a line that is no event is counted as ``bad_record`` with its offset."""

    def __init__(self, path: Path, options: Options) -> None:
        self._path = path
        with path.open("rb") as file:
            self._layout = _find_layout(path, _front(file), options)
        self.format = "csv" if self._layout.separator in b",;" else "text"
        self.width, self.height = self._layout.width, self._layout.height
        #: Events in the file, about: its lines are seldom shorter than the first.
        self.expected = int((path.stat().st_size - self._layout.start) / self._layout.line_bytes)

    def chunks(self, losses: Losses, from_us: int | None = None) -> Iterator[Events]:
        """Decode from the first line, or from one before `from_us`."""
        start = self._layout.start
        if from_us is None:
            return self._decoded(losses, start)
        with self._path.open("rb") as file:

            def line_at(piece: int) -> int:
                file.seek(start + piece * _PIECE)
                if piece:
                    file.readline(_PIECE)
                return file.tell()

            def time_of(piece: int) -> int | None:
                at = line_at(piece)
                return first_us(self._decoder(losses, at).decode(file.read(_HEAD)))

            pieces = max((self._path.stat().st_size - start) // _PIECE, 1)
            return self._decoded(losses, line_at(row_before(time_of, pieces, from_us)))

    def _decoder(self, losses: Losses, at: int) -> _core.TextDecoder:
        return _core.TextDecoder(
            order=self._layout.order,
            time_exponent=time_exponent(self._layout.unit),
            clamp=losses.on_bad == "clamp",
            first_offset=at,
        )

    def _decoded(self, losses: Losses, at: int) -> Iterator[Events]:
        losses.guessed_unit = self._layout.unit if self._layout.guessed else None
        decoder = self._decoder(losses, at)
        last_line = at
        zeros = _core.data_end(self._path)
        end = zeros or self._path.stat().st_size
        with self._path.open("rb") as file:
            file.seek(at)
            while piece := file.read(min(_PIECE, max(end - at, 0))):
                if b"\n" in piece:
                    last_line = at + piece.rindex(b"\n") + 1
                at += len(piece)
                yield self._counted(decoder, decoder.decode(piece), losses)
        if zeros:
            losses.zeros(zeros)
            return
        events, ended_well = decoder.finish()
        yield self._counted(decoder, events, losses)
        if not ended_well:
            losses.truncated(last_line, "the last line is cut")

    def _counted(self, decoder: _core.TextDecoder, events: Events, losses: Losses) -> Events:
        losses.out_of_bounds = decoder.out_of_bounds
        losses.clamped_positions = decoder.clamped_positions
        losses.take_bad_records(decoder, self._line_at)
        losses.between_pixels = decoder.bad_records if self._layout.between_pixels else 0
        check_polarity(events["p"], losses)
        return events

    def _line_at(self, offset: int) -> str:
        with self._path.open("rb") as file:
            file.seek(offset)
            line = file.readline(80).strip().decode("ascii", "replace")
        return f"no event {self._layout.order!r}: {line!r}"


def _front(file: IO[bytes]) -> bytes:
    """Read the comments that come first, however long they are, and whole lines that follow."""
    lines, size = [], 0
    while size < _MAX and (line := file.readline(_MAX)):
        lines.append(line)
        size += len(line)
        if line.strip() and line.lstrip()[:1] not in b"#%":
            break
    rest = file.read(_HEAD).rstrip(b"\0")
    return b"".join(lines) + (rest if len(rest) < _HEAD else rest[: rest.rfind(b"\n") + 1])


def _find_layout(path: Path, head: bytes, options: Options) -> _Layout:
    at = 3 if head.startswith(b"\xef\xbb\xbf") else 0
    names: list[str] = []
    sensor: tuple[int, int] | None = None
    comments: list[bytes] = []
    start = at
    rows: list[list[bytes]] = []
    separator = b" "
    for line in head[at:].splitlines(keepends=True):
        at += len(line)
        text = line.strip()
        if not text or text[:1] in b"#%":
            comments.append(text.lower())
            if not rows and not names:
                names = _names(text.lstrip(b"#% \t"), commented=True)
            continue
        if _QUOTED.search(text):
            raise CorruptFile(path, at - len(line), "numbers in quotes; write them without")
        fields = [_TRUTHS.get(field, field) for field in _SEPARATORS.split(text) if field]
        numeric = [_NUMBER.fullmatch(field) is not None for field in fields]
        if not rows and not any(numeric):
            names = _names(text, commented=False)
            start = at
        elif not rows and sensor is None and (sides := _SIDES.fullmatch(text)):
            sensor = (int(sides[1]), int(sides[2]))
            start = at
        elif all(numeric):
            if _DECIMAL_COMMA.search(text):
                fault = "numbers with a decimal comma; write them with a point"
                raise CorruptFile(path, at - len(line), fault)
            rows.append(fields)
            separator = separator if len(rows) > 1 else _separator(text)
    is_prose = bool(names) and not _name_events(names) and max(map(len, rows), default=0) < 3
    if is_prose and options.order is None:
        raise CorruptFile(path, 0, "text without lines of numbers, such as 't x y p'")
    unit = options.time_unit
    if options.order is not None:
        order = check_order(options.order)
    elif names:
        order, named_unit = _order_of(path, names)
        unit = unit or named_unit
    else:
        order = "txyp"
    if rows:
        rows = _of_common_length(path, rows, order, options.order is not None or bool(names))
        if options.order is None and not names:
            _check_columns(path, rows)
    if sensor is None and (size := _SENSOR.search(b"\n".join(comments))):
        first, second = (int(side) for side in size.groups() if side)
        sensor = (second, first) if size["height"] is not None else (first, second)
    width, height = sensor or (None, None)
    guessed = unit is None
    unit = unit or _unit_of(path, rows, order)
    line_bytes = max((at - start) / max(len(rows), 1), _SHORTEST)
    places = [order.index(role) for role in "xy"]
    between = [row for row in rows if any(not float(row[at]).is_integer() for at in places)]
    mostly = 2 * len(between) > len(rows)
    return _Layout(order, unit, start, separator, width, height, line_bytes, guessed, mostly)


def _separator(text: bytes) -> bytes:
    return next((mark for mark in (b",", b";", b"\t") if mark in text), b" ")


def _names(text: bytes, *, commented: bool) -> list[str]:
    """Column names of a header line; of a comment only if they contain t, x and y."""
    line = re.sub(r"\s+(?=[\[(])", "", text.decode("utf-8", "replace").lower())  # before a unit
    line = line.rstrip(",; \t")  # where each line ends in one
    split = re.split(r"[,;]", line) if re.search(r"[,;]", line) else line.split()
    names = [name.strip().strip("\"'") for name in split]
    return names if _name_events(names) or not commented else []


def _name_events(names: list[str]) -> bool:
    return {"t", "x", "y"} <= {_role(name)[0] for name in names}


def _role(name: str) -> tuple[str, str | None]:
    """Role of a column, '-' for none, and the unit that its name states."""
    if name in ROLES:
        return ROLES[name], None
    for known_time in sorted(FIELD_NAMES["t"], key=len, reverse=True):
        unit = _UNIT.fullmatch(name[len(known_time) :]) if name.startswith(known_time) else None
        if unit:
            return "t", _UNITS.get(unit[1], unit[1])
    return "-", None


def _order_of(path: Path, names: list[str]) -> tuple[str, str | None]:
    roles = [_role(name) for name in names]
    order = "".join(role for role, _ in roles)
    if sorted(order.replace("-", "")) not in (sorted("txyp"), sorted("txy")):
        raise ValueError(
            f"order = None: the header of {path} names the columns {', '.join(names)}; "
            "say what they are, such as order='txyp'"
        )
    return order, next((unit for role, unit in roles if role == "t"), None)


def _of_common_length(
    path: Path, rows: list[list[bytes]], order: str, known: bool
) -> list[list[bytes]]:
    length, _ = Counter(map(len, rows)).most_common(1)[0]
    alike = [row for row in rows if len(row) == length]
    if length != len(order):
        what = f"order = {order!r}" if known else "order = None"
        remedy = "name each, such as order=" + repr("txyp"[:length].ljust(length, "-"))
        remedy += " where '-' skips one" * (length > 4)
        raise ValueError(f"{what}: the lines of {path} have {length} columns; {remedy}")
    return alike


def _check_columns(path: Path, rows: list[list[bytes]]) -> None:
    """Refuse to take four columns for t, x, y and p where the first rows say otherwise."""
    polarity = [float(row[3]) for row in rows]
    wide = {p for p in polarity if abs(p) > 127 or p != int(p)}
    if len(wide) > 1 or polarity == [*wide]:  # one may be the -1 of a type without a sign
        first = rows[0][3].decode()
        words, order = f"fourth column of {path} holds no polarity (it begins with {first})", "xypt"
    elif _goes_back(rows, 0) and not _goes_back(rows, 2) and rows[0][2] != rows[-1][2]:
        words, order = f"third column of {path} ascends, the first one does not", "xytp"
    else:
        return
    remedy = f"say what the columns are, such as order={order!r}"
    raise ValueError(f"order = None: the {words}; {remedy}")


def _goes_back(rows: list[list[bytes]], column: int) -> bool:
    times = [float(row[column]) for row in rows]
    return times != sorted(times)


def _unit_of(path: Path, rows: list[list[bytes]], order: str) -> str:
    times = [row[order.index("t")] for row in rows]
    are_floats = any(map(_is_float, times))
    numbers = np.array([float(time) for time in times])
    if not are_floats and not are_thousands(numbers.astype(np.int64)):
        return "us"
    if not are_floats or np.array_equal(numbers, np.floor(numbers)):
        raise unclear_unit(path, are_floats)
    return "s"


def _is_float(field: bytes) -> bool:
    return any(mark in field for mark in b".eE")
