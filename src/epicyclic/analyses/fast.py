"""Whether numba, the extra `fast`, is there."""

from __future__ import annotations

from importlib import import_module

from ..errors import ModelError

__all__ = ["numba_is_there", "require_numba"]


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
