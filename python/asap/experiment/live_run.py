"""Run a camera: a pipeline with a log of 2^20 packages, and the Run made of it."""

from __future__ import annotations

import warnings
from typing import Any

from asap import _checks
from asap.experiment.pipeline import Pipeline
from asap.experiment.runners import keep, thread_held_s
from asap.results import Ledger, Run


class CameraRun(Pipeline):
    """A pipeline for one run of a camera, of `duration_s` at most."""

    _log_rows = 1 << 20  # of 96 bytes; a page of them is only taken when it is written

    def __init__(self, algorithm: Any, camera: Any, duration_s: float | None, **options: Any):
        if duration_s is not None:
            remedy = "give the seconds that the run may last"
            _checks.number("duration_s", duration_s, 1e-3, 1e9, remedy)
        super().__init__(algorithm, camera=camera, **options)
        self._duration_s = duration_s

    def run_camera(self, on_progress: Any) -> Run:
        """Work on this thread until the camera ends or the time is over; `last_run` has the Run."""

        def poll() -> None:
            self._log.look()
            if on_progress is not None:
                counts = dict(self.ledger)
                on_progress(counts["received"] - counts["pending"], None, counts)

        held_s = thread_held_s()
        try:
            with self:
                self._native.run(self.algorithm, poll)
                self._log.look(now=True)
        finally:
            run = keep(self._outcome(thread_held_s(held_s)))
        self._camera._raise_error()
        if run.ledger.received == 0:
            silent = f"{self._camera}: no event came; look at its lens cap, its biases, the scene"
            warnings.warn(silent, RuntimeWarning, stacklevel=4)
        return run

    def _outcome(self, held_s: float | None) -> Run:
        stats = self._native.stats()
        ledger = Ledger(**stats.ledger)
        return Run(
            packages=self._native.packages,
            ledger=ledger,
            latency=stats.latency,
            rejected=stats.rejected,
            scheme=self.scheme,
            algorithm=self.algorithm,
            mode="real",
            latency_bound_us=stats.latency_bound_us,
            source={
                "path": None,
                "format": str(self._camera),
                "width": self._sensor[0],
                "height": self._sensor[1],
                "events": ledger.received,
                "duration_s": stats.elapsed_s,
                "upstream_lost": self.stats()["upstream_lost"],
            },
            clock_resets=stats.clock_resets,
            gap_us=stats.gap_us,
            execution=self._config.execution,
            seed=self._config.seed,
            held_s=held_s,
        )
