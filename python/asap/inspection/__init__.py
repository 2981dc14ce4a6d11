"""Inspection of a recording: what is wrong with it, how often, where first, and what helps."""

from asap.inspection.conduct import check
from asap.inspection.result import Finding, Inspection

__all__ = ["Finding", "Inspection", "check"]
