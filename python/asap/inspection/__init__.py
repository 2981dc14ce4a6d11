"""What a recording holds, and what is wrong with it: how often, where first, and what helps."""

from asap.inspection.checking import check, info
from asap.inspection.result import Finding, Inspection

__all__ = ["Finding", "Inspection", "check", "info"]
