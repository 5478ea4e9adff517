"""Two published systems that tests of several rooms share; they are skipped where their arrays are absent."""

from __future__ import annotations

import gc
import os
import signal
import sys
import time
from collections.abc import Iterator
from importlib import import_module
from importlib.util import cache_from_source
from pathlib import Path
from typing import Any

import known
import pytest

from epicyclic.engine.workers import keep_freed_memory
from epicyclic.system.system import System

# as a process of the package does
keep_freed_memory()
# Tests share the cores among themselves; one that is about several processes asks for them.
os.environ.setdefault("EPICYCLIC_JOBS", "1")
# Tables are as wide as in a pipe: pytest-xdist sets the width of its own terminal for its processes.
os.environ.pop("COLUMNS", None)
# A shell lets what it starts in the background ignore Ctrl-C, and so would the processes that tests stop by it.
signal.signal(signal.SIGINT, signal.default_int_handler)


# One process has the browser and its server from the beginning; the longest file is not left to the end.
_ALONE, _LONGEST = "tests/app/", "tests/unit/test_docs_run.py"
# Priority (nice) of a job of the page.
_BEHIND = 10
# The results of the examples of all verbs, `example_result`, are computed in one process.
_EXAMPLES = ("tests/unit/show/test_terminal.py", "tests/unit/test_docs.py")


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """With `--dist loadfile` each process takes whole files, and one of them those that share what is dear."""
    if config.getoption("dist") != "loadfile":
        return None
    scheduling = import_module("xdist.scheduler").LoadFileScheduling(config, log)

    def scope(nodeid: str) -> str:
        if nodeid.startswith(_EXAMPLES):
            return _EXAMPLES[0]
        return _ALONE if nodeid.startswith(_ALONE) else nodeid.partition("::")[0]

    scheduling._split_scope = scope
    return scheduling


@pytest.hookimpl(tryfirst=True)
def pytest_collection(session: pytest.Session) -> None:
    """Where no test is compiled yet, one process compiles them all, and the others wait for the last of them.

    Each would take twelve seconds for what they write to the same place.
    """
    worker = getattr(session.config, "workerinput", {"workerid": "gw0"})["workerid"]
    last = max((session.config.rootpath / "tests" / "unit" / "verbs").glob("test_*.py"))
    compiled = Path(cache_from_source(str(last)).replace(".pyc", f"-pytest-{pytest.__version__}.pyc"))
    if session.config.args != ["tests"] or sys.dont_write_bytecode or worker == "gw0":
        return
    until = time.monotonic() + 60
    while not compiled.exists() and time.monotonic() < until:
        time.sleep(0.1)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    items.sort(key=lambda item: (not item.nodeid.startswith(_ALONE), not item.nodeid.startswith(_LONGEST)))


def pytest_collection_finish() -> None:
    _freeze()


def pytest_runtest_setup(item: pytest.Item) -> None:
    """Beside other processes a test of something else than the page has the priority of the jobs of the page.

    There are more processes than cores, and a job, which stands behind the page, would hardly run.
    """
    if hasattr(item.config, "workerinput") and not item.nodeid.startswith(_ALONE) and hasattr(os, "nice"):
        os.nice(max(0, _BEHIND - os.nice(0)))


def pytest_runtest_teardown(item: pytest.Item, nextitem: pytest.Item | None) -> None:
    if nextitem is None or nextitem.path != item.path:
        _freeze()


def _freeze() -> None:
    """Leave what lives out of later collections, of which each test of the page asks for two."""
    gc.collect()
    gc.freeze()


@pytest.fixture
def slowness() -> float:
    """Allowance of a limit of time: how many times slower than where it was set a fixed loop runs, at least 1; times 5.

    A loop says nothing of caches and clocks that other processes share, so a limit catches a change of order alone;
    `make bench` measures.
    """
    took = []
    for _ in range(3):
        start, total = time.process_time(), 0
        for i in range(1_000_000):
            total += i
        took.append(time.process_time() - start)
    return 5 * max(1.0, min(took) / 0.053)


@pytest.fixture(scope="module")
def few_turning_trains() -> Iterator[None]:
    """`output` samples its error by eight trains that turn, not 64: enough where no test looks at their quantiles."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("epicyclic.questions.output.output._TURNING", 8)
        yield


@pytest.fixture(scope="session")
def bench56() -> System:
    """A double-helical planetary set of 56 degrees of freedom."""
    try:
        return known.bench56()
    except FileNotFoundError as error:
        pytest.skip(str(error))


@pytest.fixture(scope="session")
def bench112() -> System:
    """Two of them, sun welded to carrier, 3 % modal damping."""
    try:
        return known.bench112()
    except FileNotFoundError as error:
        pytest.skip(str(error))
