"""numba, the extra `fast`: whether it is there, and functions compiled by it."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import TypeVar, cast

from ..errors import ModelError

__all__ = ["compiled", "numba_is_there", "require_numba"]

F = TypeVar("F", bound=Callable[..., object])


def compiled(function: F) -> F:
    """Compiled on first use and kept on disk; sums in any order, numbers that are not finite stay as they are.

    Only in modules that are themselves imported where they are used.  A caller kept on disk does not notice a change in
    a function of another file, so functions that call each other stand in one.
    """
    import numba

    return cast(F, numba.njit(cache=True, error_model="numpy", fastmath={"reassoc", "contract", "nsz"})(function))


def numba_is_there() -> bool:
    """Whether numba can be imported; it is imported by asking."""
    try:
        import_module("numba")
    except ImportError:
        return False
    return True


def require_numba(path: str) -> None:
    """Raise ModelError, naming the option `path`, where numba is not there."""
    if not numba_is_there():
        raise ModelError("numba is not installed", path=path, given=True, allowed="pip install 'epicyclic[fast]'")
