"""The optional compiler numba (extra `fast`): whether it is installed, and functions compiled by it."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import TypeVar

from ..errors import ModelError
from ..machine_code import machine_code

__all__ = ["compiled", "numba_available", "require_numba"]

F = TypeVar("F", bound=Callable[..., object])


def compiled(function: F) -> F:
    """Compile a function on first use and keep it on disk; sums in any order, numbers that are not finite stay as they
    are.

    Use it only in modules that are imported where they are used.  A caller kept on disk does not notice a change in a
    function of another file: compiled functions that call each other stand in one file.
    """
    return machine_code(function, fastmath={"reassoc", "contract", "nsz"})


def numba_available() -> bool:
    """Whether numba can be imported; the test imports it."""
    try:
        import_module("numba")
    except ImportError:
        return False
    return True


def require_numba(path: str) -> None:
    """Refuse an option that needs numba where it is not installed.

    Raises
    ------
    ModelError : numba cannot be imported; names the option `path`.
    """
    if not numba_available():
        raise ModelError("numba is not installed", path=path, given=True, allowed="pip install 'epicyclic[fast]'")
