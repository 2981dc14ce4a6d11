"""ROS bags as topics and raw messages: ROS 1, MCAP and folders through ``rosbags``.

A recorder that crashes, a full disk or a copy that broke off leaves a bag without its index, which
the library refuses. Such a bag is read from the front, up to the first record that is not whole. So
is one with a damaged chunk, at which the library stops: that chunk is then missing.
Databases are read with ``sqlite3``, because the library takes zeros for a page that is cut.
"""

from __future__ import annotations

import errno
import shutil
import tempfile
from collections.abc import Callable, Collection, Iterator
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from typing import Any, Protocol

from asap.io.bag_records import (
    Channel,
    Records,
    mcap_records,
    rosbag1_chunk_sizes,
    rosbag1_records,
)
from asap.io.errors import CorruptFile, foreign, library, refuse_bomb


class Bag(Protocol):
    """The topics of a bag and their messages."""

    topics: dict[str, str]  # type of each, "package/Type"

    def messages(self, topic: str) -> Iterator[bytes | CorruptFile]:
        """Yield the messages of a topic as they were recorded; an error in place of a lost chunk.

        Raises
        ------
        CorruptFile
            After the last good one, if there should be more.
        """
        ...


def open_bag(kind: str, path: Path) -> Bag:
    """Open a bag of `kind`: ``"rosbag1"``, ``"rosbag2"`` (a file or a folder) or ``"mcap"``."""
    if kind == "rosbag2" and not path.is_dir():
        return _Database(path)
    make_reader = _library_reader(kind, path)
    walk = rosbag1_records if kind == "rosbag1" else mcap_records
    try:
        return _WholeBag(path, make_reader, walk)
    except CorruptFile as error:
        if path.is_dir():
            raise
        return _DamagedBag(path, walk, error.fault)


def _library_reader(kind: str, path: Path) -> Callable[[], Any]:
    if kind == "rosbag1":
        rosbag1 = library("rosbags.rosbag1", "A ROS 1 bag", "ros")
        return lambda: rosbag1.Reader(path)
    what, key = ("An MCAP file", ".mcap") if kind == "mcap" else ("A folder of ROS 2", "dir")
    reader = library("rosbags.rosbag2", what, "ros").Reader.STORAGE_PLUGINS[key]
    return lambda: reader(path)  # by content: Reader() would go by the suffix


def _plain(msgtype: str) -> str:
    return msgtype.replace("/msg/", "/")


@contextmanager
def _library_errors(path: Path) -> Iterator[None]:
    with foreign(path):
        try:
            yield
        except OSError as error:
            if error.errno != errno.EINVAL:
                raise
            raise ValueError("its index points outside of it") from error


class _WholeBag:
    """A bag that the library opens."""

    def __init__(
        self, path: Path, make_reader: Callable[[], Any], walk: Callable[[Path], Records]
    ) -> None:
        self._path, self._make_reader, self._walk = path, make_reader, walk
        with self._opened() as reader, _library_errors(path):
            self.topics = {c.topic: _plain(c.msgtype) for c in reader.connections}
            for offset, unpacked, packed in self._chunk_sizes(reader):
                refuse_bomb(path, offset, "the chunk", unpacked, packed)

    def messages(self, topic: str) -> Iterator[bytes | CorruptFile]:
        count, last = 0, b""
        with self._opened() as reader:
            wanted = [c for c in reader.connections if c.topic == topic]
            try:
                with _library_errors(self._path):
                    for _, _, data in reader.messages(wanted):
                        last = data if isinstance(data, bytes) else b""  # in a database: anything
                        yield last
                        count += 1
                return
            except CorruptFile as error:
                words = f"{error.fault} (after {count} messages of {topic})"
                fault = CorruptFile(self._path, _position(reader), words)
        if self._path.is_dir():
            raise fault
        yield from self._behind(count, last, {c.id for c in wanted}, fault)

    def _behind(
        self, count: int, last: bytes, channels: Collection[int], fault: CorruptFile
    ) -> Iterator[bytes | CorruptFile]:
        """Go on behind the message that the library gave last, unless the file has another order.

        `fault` is raised if nothing else is wrong with the file.
        """
        is_told = False
        for found in _messages(self._walk(self._path), channels):
            if isinstance(found, CorruptFile):
                is_told = True
            elif count > 0:
                count -= 1
                if count == 0 and found != last:
                    raise fault
                continue
            yield found
        if not is_told:
            raise fault

    def _chunk_sizes(self, reader: Any) -> Iterator[tuple[int, int, int]]:
        chunks = getattr(reader, "chunks", ())
        if isinstance(chunks, dict):  # ROS 1
            yield from rosbag1_chunk_sizes(self._path, chunks)
        else:
            for chunk in chunks:
                yield chunk.chunk_start_offset, chunk.uncompressed_size, chunk.compressed_size

    @contextmanager
    def _opened(self) -> Iterator[Any]:
        with _library_errors(self._path):
            reader = self._make_reader()
            try:
                reader.open()
            except BaseException:
                with suppress(Exception):  # older ones leave the file open
                    reader.close()
                raise
        with closing(reader):
            yield reader


def _position(reader: Any) -> int:
    """Where the library was in the file; 0 in a database or a folder."""
    file = getattr(reader, "bio", None)
    return file.tell() if file is not None else 0


def _messages(records: Records, channels: Collection[int]) -> Iterator[bytes | CorruptFile]:
    for record in records:
        if isinstance(record, CorruptFile):
            yield record
        elif not isinstance(record, Channel) and record.channel in channels:
            yield record.data


class _DamagedBag:
    """A ROS 1 bag or an MCAP file, read from the front."""

    def __init__(self, path: Path, walk: Callable[[Path], Records], fault: str) -> None:
        self._path, self._walk, self._fault = path, walk, fault
        self.topics: dict[str, str] = {}
        self._channels: dict[str, set[int]] = {}
        end = CorruptFile(path, path.stat().st_size, fault)
        try:
            for record in walk(path):
                if isinstance(record, Channel):
                    self.topics[record.topic] = _plain(record.type)
                    self._channels.setdefault(record.topic, set()).add(record.number)
                elif isinstance(record, CorruptFile):
                    end = record
        except CorruptFile as error:
            end = error
        if not self.topics:
            raise end

    def messages(self, topic: str) -> Iterator[bytes | CorruptFile]:
        yield from _messages(self._walk(self._path), self._channels[topic])
        raise CorruptFile(self._path, self._path.stat().st_size, self._fault)


class _Database:
    """A ROS 2 bag in one SQLite file: the rows up to the first page that is not good."""

    def __init__(self, path: Path) -> None:
        self._path, self._size = path, path.stat().st_size
        with path.open("rb") as file:
            header = file.read(100)
        page, pages = (int.from_bytes(header[at:end], "big") for at, end in ((16, 18), (28, 32)))
        self._page = {0: 1, 1: 65536}.get(page, page)  # bytes
        is_valid = header[24:28] == header[92:96]  # the number of pages
        self._promised = self._page * pages if is_valid else 0
        rows = self._rows("SELECT name, type FROM topics")
        self.topics = {str(name): _plain(str(kind)) for name, kind in rows}
        if not self.topics:
            self._check_whole()

    def messages(self, topic: str) -> Iterator[bytes]:
        wanted = "topic_id IN (SELECT id FROM topics WHERE name = ?)"
        query = f"SELECT CAST(data AS BLOB) FROM messages WHERE {wanted} ORDER BY id"
        for (data,) in self._rows(query, topic):
            yield data or b""
        self._check_whole()

    def _check_whole(self) -> None:
        if self._size < self._promised:
            raise CorruptFile(self._path, self._size, f"{self._promised} bytes are promised")

    def _rows(self, query: str, *values: str) -> Iterator[tuple[Any, ...]]:
        sqlite3 = library("sqlite3", "A ROS 2 bag", "ros")
        try:
            with self._whole_pages() as path:
                uri = f"{path.absolute().as_uri()}?mode=ro&immutable=1"
                with closing(sqlite3.connect(uri, uri=True)) as database:
                    database.execute("PRAGMA writable_schema = ON")  # else a cut one is refused
                    yield from database.execute(query, values)
        except sqlite3.Error as error:
            raise CorruptFile(self._path, self._size, f"SQLite: {error}") from error

    @contextmanager
    def _whole_pages(self) -> Iterator[Path]:
        """Give the file without a page that is cut, which SQLite would fill up with zeros."""
        rest = self._size % self._page
        if rest == 0:
            yield self._path
            return
        with tempfile.NamedTemporaryFile() as copy:
            with self._path.open("rb") as file:
                shutil.copyfileobj(file, copy)
            copy.truncate(self._size - rest)
            yield Path(copy.name)
