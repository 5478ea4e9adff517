"""Version of the package, as results, folders of runs and the command line state it."""

from __future__ import annotations

from functools import cache
from importlib.metadata import PackageNotFoundError, version

__all__ = ["package_version"]


@cache
def package_version() -> str:
    """The version that is installed; "unknown" of a source tree that is not."""
    try:
        return version(__name__.partition(".")[0])
    except PackageNotFoundError:
        return "unknown"
