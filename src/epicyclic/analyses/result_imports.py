"""Import of the room of results, xarray and pandas with it, ahead of time: while workers compute the points."""

from __future__ import annotations

__all__ = ["import_results"]


def import_results() -> None:
    """Import what a result is made and shown with: a quarter of a second, in which this process has nothing to do."""
    from ..results import dataset  # noqa: F401
