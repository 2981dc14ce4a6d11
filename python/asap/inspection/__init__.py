"""What a recording holds, and what is wrong with it: how often, where first, and what helps."""

from asap.inspection.conduct import check
from asap.inspection.facts import info
from asap.results import Finding, Inspection

__all__ = ["Finding", "Inspection", "check", "info"]
