"""CPU time of repeated runs in this process."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable

__all__ = ["cpu_seconds"]


def cpu_seconds(run: Callable[[], object], *, repeats: int) -> tuple[float, float]:
    """Median and smallest CPU time of several runs after one to warm up [s]."""
    run()
    spent = []
    for _ in range(repeats):
        clock = time.process_time()
        run()
        spent.append(time.process_time() - clock)
    return statistics.median(spent), min(spent)
