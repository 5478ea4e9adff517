"""The compiled solver, made ready beside the work: its first use ever compiles for some 20 s, each other for half one.

A process of its own compiles, which leaves the result on disk, as numba does; then a thread loads it here.  Until then
all is solved by numpy.
"""

from __future__ import annotations

import subprocess
import sys
import threading
from collections.abc import Callable

from ...machine_code import numba_available

__all__ = ["compile_aside", "compiler_ready"]

_ready = threading.Event()
_started = threading.Event()


def compiler_ready() -> bool:
    """Whether the compiled solver is loaded in this process."""
    return _ready.is_set()


def compile_aside(module: str, function: str) -> threading.Thread | None:
    """Compile in a process of its own, load here when that is done; None where numba is missing or it has been begun.

    Parameters
    ----------
    module, function : what to call, here and there, so that everything is compiled.
    """
    if _started.is_set() or not numba_available():
        return None
    _started.set()
    load: Callable[[], None] = getattr(sys.modules[module], function)
    thread = threading.Thread(
        target=_compile, args=(f"from {module} import {function}; {function}()", load), daemon=True
    )
    thread.start()
    return thread


def _compile(code: str, load: Callable[[], None]) -> None:
    """Run Python code in a process of the group of this one, then `load` here."""
    try:
        # no shell, no input of the user
        done = subprocess.run(
            [sys.executable, "-c", code], stdin=subprocess.DEVNULL, capture_output=True, check=False, timeout=600
        )
        if done.returncode == 0:
            load()
            _ready.set()
    except (OSError, subprocess.SubprocessError):
        return  # numpy does all of it
