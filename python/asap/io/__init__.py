"""Event files: which format it is, and the events in it, checked and in chunks."""

from asap.events.order import Slice
from asap.io.errors import (
    CorruptFile,
    LossWarning,
    NoGoodEvent,
    TruncatedFileWarning,
    UnsupportedFormat,
)
from asap.io.recording import FILE_FORMATS, Recording, load, read

__all__ = [
    "FILE_FORMATS",
    "CorruptFile",
    "LossWarning",
    "NoGoodEvent",
    "Recording",
    "Slice",
    "TruncatedFileWarning",
    "UnsupportedFormat",
    "load",
    "read",
]
