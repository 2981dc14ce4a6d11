"""As much of FlatBuffers as AEDAT4 needs: the root table of a buffer, every offset checked.

Positions count from the start of the buffer, behind its size prefix. What lies outside raises
``struct.error``.
"""

from __future__ import annotations

import struct

Buffer = bytes | memoryview


class Table:
    """The root table: its fields by their number in the schema."""

    def __init__(self, buffer: Buffer) -> None:
        self.buffer = buffer
        self._at = self._read("<I", 0)
        self._fields = self._at - self._read("<i", self._at)
        self._size = self._read("<H", self._fields)

    @property
    def name(self) -> bytes:
        """The four bytes that name the schema."""
        return bytes(self.buffer[4:8])

    def number(self, field: int, kind: str, default: int) -> int:
        """Return a field of the type `kind` of ``struct``."""
        at = self._place(field)
        return default if at is None else self._read(kind, at)

    def vector(self, field: int) -> tuple[int, int]:
        """Where the elements of a vector or a text begin, and how many there are."""
        at = self._place(field)
        if at is None:
            return 0, 0
        at += self._read("<I", at)
        return at + 4, self._read("<I", at)

    def _place(self, field: int) -> int | None:
        slot = 4 + 2 * field
        offset = self._read("<H", self._fields + slot) if slot + 2 <= self._size else 0
        return self._at + offset if offset else None

    def _read(self, kind: str, at: int) -> int:
        if at < 0:
            raise struct.error(f"offset {at} is outside the buffer")
        return int(struct.unpack_from(kind, self.buffer, at)[0])
