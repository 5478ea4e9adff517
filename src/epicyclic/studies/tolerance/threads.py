"""Linear algebra in one thread: the bits of a product change with the number of threads."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager

from ...analyses.parallel import BLAS_THREADS

__all__ = ["one_thread"]


@contextmanager
def one_thread() -> Iterator[str]:
    """Let linear algebra take one thread in the block, where threadpoolctl is installed; the command line sets the
    environment.

    Yields the number of threads as far as it is known: ``1``, a number of the environment, or ``unknown``.
    """
    try:
        from threadpoolctl import threadpool_limits
    except ImportError:
        yield next((os.environ[name] for name in BLAS_THREADS if os.environ.get(name, "").isdigit()), "unknown")
        return
    with threadpool_limits(limits=1, user_api="blas"):
        yield "1"
