"""Functions compiled by numba on first use and kept on disk, where the disk takes them.

The optional compiler numba (extra `fast`): whether it is installed, and functions compiled by it.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from importlib import import_module
from typing import Any, TypeVar, cast

F = TypeVar("F", bound=Callable[..., object])


def machine_code(function: F, **options: Any) -> F:
    """Compile a function on first use, without checks of divisions, and keep it on disk for the next process.

    An installation that is read-only beside a home that is none, or a full disk, keeps nothing: each process then
    compiles for itself.  A caller kept on disk does not notice a change in a function of another file: functions that
    call each other stand in one file, imported where it is used.

    Parameters
    ----------
    options : of ``numba.njit``.
    """
    import numba
    from numba.core.caching import FunctionCache

    class Kept(FunctionCache):
        """The files of a function; one that cannot be written is left out."""

        def save_overload(self, signature: Any, code: Any) -> None:
            with suppress(OSError):
                try:
                    super().save_overload(signature, code)  # type: ignore[no-untyped-call]
                except RuntimeError as error:
                    if "no compiled object" not in str(error):
                        raise
                    # Ctrl-C fell in the function that LLVM calls with the code, where ctypes drops it
                    raise KeyboardInterrupt from None

    made = numba.njit(error_model="numpy", **options)(function)
    with suppress(RuntimeError):  # no folder that can be written
        made._cache = Kept(function)  # type: ignore[no-untyped-call]
    return cast(F, made)


def numba_available() -> bool:
    """Whether numba can be imported; the test imports it."""
    try:
        import_module("numba")
    except ImportError:
        return False
    return True
