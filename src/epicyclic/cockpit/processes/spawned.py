"""Processes of the cockpit: started anew (spawn), in a group of their own, with one thread of linear algebra."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import threading
import warnings
from collections.abc import Callable
from contextlib import suppress
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess
from types import ModuleType
from typing import Any

from ...analyses.parallel import BLAS_THREADS

__all__ = ["kill_group", "spawned"]

_CONTEXT = multiprocessing.get_context("spawn")


def spawned(function: Callable[..., None], *arguments: Any) -> tuple[SpawnProcess, Connection]:
    """A process that runs function(connection, *arguments), and this end of its pipe; Ctrl-C does not reach it.

    function : of a module, so that it can be pickled.
    """
    ours, theirs = _CONTEXT.Pipe()
    process = _CONTEXT.Process(target=_begin, args=(function, theirs, *arguments), daemon=False)
    main, before = sys.modules["__main__"], {name: os.environ.get(name) for name in BLAS_THREADS}
    # a process started anew would run the script again, of which it needs nothing
    sys.modules["__main__"] = ModuleType("__main__")
    os.environ.update(dict.fromkeys(BLAS_THREADS, "1"))
    try:
        process.start()
    finally:
        sys.modules["__main__"] = main
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
    theirs.close()
    return process, ours


def kill_group(process: SpawnProcess) -> None:
    """Kill a process and those it has started."""
    if process.pid is None:
        return
    with suppress(ProcessLookupError, PermissionError):
        if hasattr(os, "killpg"):
            os.killpg(process.pid, signal.SIGKILL)
        else:
            process.kill()
    with suppress(OSError, ValueError):
        process.kill()


def _begin(function: Callable[..., None], connection: Connection, *arguments: Any) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(os, "setpgid"):
        with suppress(OSError):
            os.setpgid(0, 0)
    threading.Thread(target=_die_with_parent, daemon=True).start()
    warnings.simplefilter("ignore")  # nobody reads the terminal; results carry their warnings
    function(connection, *arguments)


def _die_with_parent() -> None:
    """End this process and those it has started when the one that started it ends."""
    parent = multiprocessing.parent_process()
    if parent is None:
        return
    parent.join()
    if hasattr(os, "killpg") and os.getpgid(0) == os.getpid():
        os.killpg(os.getpid(), signal.SIGKILL)
    os._exit(1)
