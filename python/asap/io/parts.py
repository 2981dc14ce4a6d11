"""Recordings of several files."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from asap.events import Events
from asap.io.reader import Losses, Options, Reader


class PartsReader:
    """The events of several files of one format, one file after the other."""

    def __init__(
        self, make: Callable[[Path, Options], Reader], paths: Sequence[Path], options: Options
    ) -> None:
        self._paths = paths
        self._readers = [make(path, options) for path in paths]
        sizes = [(reader.width, reader.height) for reader in self._readers]
        self.width, self.height = next((size for size in sizes if all(size)), sizes[0])
        for path, size in zip(paths, sizes, strict=True):
            if all(size) and size != (self.width, self.height):
                raise ValueError(
                    f"path = {path}: its sensor has {size[0]} x {size[1]} px, that of "
                    f"{paths[0]} {self.width} x {self.height}; give the parts of one recording"
                )
        self.format = self._readers[0].format
        self.streams = getattr(self._readers[0], "streams", ())
        self.expected = sum(getattr(reader, "expected", 0) for reader in self._readers)

    def chunks(self, losses: Losses, from_us: int | None = None) -> Iterator[Events]:
        """Read the files in the order in which they were given."""
        for path, reader in zip(self._paths, self._readers, strict=True):
            part = Losses(path, losses.on_bad, room=losses.room)
            part.has_plain_polarity = losses.has_plain_polarity
            yield from reader.chunks(part)
            losses.add(part)
