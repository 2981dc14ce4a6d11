"""Events as bytes in an encoding of the core, piece by piece."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import IO

from asap import _core
from asap.events import Events

_PIECE = 1 << 18  # bytes


class Encoded:
    """The bytes of a stream of events: a header, then one call of `pieces` after the other."""

    def __init__(self, encoding: str, width: int, height: int) -> None:
        self._encoder = _core.Encoder(encoding, width=width, height=height)
        self._buffer = memoryview(bytearray(_PIECE))

    @property
    def header(self) -> bytes:
        """What a file begins with."""
        return self._encoder.header()

    def pieces(self, events: Events) -> Iterator[memoryview]:
        """Encode the next events; a piece is good until the next one."""
        while len(events):
            taken, written = self._encoder.encode_into(events, self._buffer)
            yield self._buffer[:written]
            events = events[taken:]


def write_encoded(
    encoding: str, file: IO[bytes], chunks: Iterable[Events], width: int, height: int
) -> int:
    """Write a file that is one stream of words, records or lines."""
    encoded = Encoded(encoding, width, height)
    file.write(encoded.header)
    count = 0
    for chunk in chunks:
        count += len(chunk)
        file.writelines(encoded.pieces(chunk))
    return count
