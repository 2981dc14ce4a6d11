"""Event files: which format it is, and the events in it, checked and in chunks."""

from asap.io.errors import CorruptFile, TruncatedFileWarning, UnsupportedFormat
from asap.io.recording import Recording, load, read

__all__ = [
    "CorruptFile",
    "Recording",
    "TruncatedFileWarning",
    "UnsupportedFormat",
    "load",
    "read",
]
