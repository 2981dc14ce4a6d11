"""The forms in which a live pipeline hands out its packages."""

from __future__ import annotations

from typing import Any

import asap


def packages_of(algorithm: Any, events: Any, **settings: Any) -> Any:
    """Give the rows of a pipeline that gets all events at once: in a loop, or by run()."""
    pipeline = asap.Pipeline(algorithm, **settings)
    pipeline.push(events)
    pipeline.stop()
    if algorithm is None:
        assert sum(len(package) for package in pipeline) == events.size
    else:
        pipeline.run()
    return pipeline.packages
