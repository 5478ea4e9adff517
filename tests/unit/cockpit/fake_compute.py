"""Processes for the tests of the worker: what they compute is known, slow on purpose, or fatal."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from multiprocessing.connection import Connection

import numpy as np

from epicyclic.cockpit.processes.worker import serve_with
from epicyclic.cockpit.state.frames import PageFrame, Request
from epicyclic.engine.plan import Counted
from epicyclic.errors import ModelError

LIVE, PART, PARTS = 0.02, 0.03, 4
LONG = 100  # parts of a frame that takes long


def compute(request: Request, *, stop: Callable[[], bool], early: Callable[[PageFrame], None]) -> Iterator[PageFrame]:
    """Frames that say which request they are of; a source names what goes wrong."""
    source = request.source if isinstance(request.source, dict) else {}
    if source.get("title") == "refuse":
        raise ModelError("too small", path="stages.main.sun.teeth", given=1, allowed="5 or more")
    if source.get("title") == "die":
        os._exit(3)
    if source.get("title") == "die once" and not os.path.exists(str(source["doi"])):
        open(str(source["doi"]), "w").close()
        os._exit(3)
    if source.get("title") == "burn":
        burn(120.0)
    if request.kind == "levers":
        yield PageFrame(rev=request.rev, kind="levers", head={"levers": [{"path": source.get("title", "")}]})
        return
    time.sleep(LIVE)
    big = np.zeros(20_000, np.float32)
    early(PageFrame(rev=request.rev, kind="curve", head={"title": source.get("title", "")}))
    yield PageFrame(rev=request.rev, kind="live", head={"title": source.get("title", "")}, arrays={"big": big})
    for part in range(PARTS):
        for _ in range(LONG if source.get("title") == "long" else 1):
            time.sleep(PART)
            if stop():
                return
        yield PageFrame(rev=request.rev, kind="sweep" if part < 2 else "sharing", head={"part": part})


def serve(connection: Connection) -> None:
    serve_with(connection, compute)


def waiting(connection: Connection) -> None:
    """What `processes.worker.waiting` does without its imports: work here needs none of them."""
    function, arguments = connection.recv()
    function(connection, *arguments)


def sleep_for(seconds: float) -> float:
    time.sleep(seconds)
    return seconds


def burn(seconds: float) -> None:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        pass


def refuse() -> None:
    raise ModelError("not so", path="a.b", given=3, allowed="4")


def serve_nothing(connection: Connection) -> None:
    """A process that ends before it is warm."""
    connection.close()


def burn_with_a_helper(seconds: float) -> None:
    """What `burn` does, with a process of its own beside it, as a study has workers."""
    code = f"import time; end = time.time() + {seconds}\nwhile time.time() < end: pass"
    other = subprocess.Popen([sys.executable, "-c", code])
    burn(seconds)
    other.wait()


def tell(*, progress: Callable[..., None]) -> tuple[None, None, int]:
    """Work that tells its share as the package does."""
    time.sleep(0.15)
    progress(Counted(1, 2))
    return None, None, 3


def burn_marked(file: str) -> None:
    """What `burn` does, told by a file when it has begun."""
    open(file, "w").close()
    burn(120.0)
