"""Compiled functions where the disk keeps nothing."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

numba = pytest.importorskip("numba")

# no folder for the files of any function, as of a read-only installation without a home
NOWHERE = """
import numba.core.caching as caching
def ensure_cache_path(self): raise OSError(30, "Read-only file system")
caching._CacheLocator.ensure_cache_path = ensure_cache_path
"""
# files that end at so many bytes, as on a full disk
FULL = "import resource; resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100))"
# Ctrl-C while LLVM compiles: Python hears of it in the function that is called with the code
STOPPED = """
import signal
from numba.core.codegen import CPUCodeLibrary
signal.signal(signal.SIGINT, signal.default_int_handler)
whole = CPUCodeLibrary._object_compiled_hook.__func__
def hook(kind, module, code):
    signal.raise_signal(signal.SIGINT)
    whole(kind, module, code)
CPUCodeLibrary._object_compiled_hook = classmethod(hook)
"""
CODE = """
from epicyclic.machine_code import machine_code
def double(number): return 2 * number
double = machine_code(double)
print(double(21), sum(double.stats.cache_misses.values()), sum(double.stats.cache_hits.values()))
"""


def run(code: str, folder: Path) -> str:
    """What a new interpreter prints for the code of a file in a folder."""
    file = folder / "doubled.py"
    file.write_text(code)
    variables = {**os.environ, "NUMBA_CACHE_DIR": ""}
    done = subprocess.run([sys.executable, str(file)], capture_output=True, text=True, env=variables, check=False)
    return done.stdout.strip() or done.stderr


@pytest.mark.parametrize("before", [NOWHERE, FULL])
def test_what_cannot_be_kept_is_compiled(before: str, tmp_path: Path) -> None:
    assert run(before + CODE, tmp_path).startswith("42 ")


def test_what_is_kept_is_not_compiled_again(tmp_path: Path) -> None:
    assert [run(CODE, tmp_path) for _ in range(2)] == ["42 1 0", "42 0 1"]


def test_ctrl_c_while_a_function_is_compiled_stops(tmp_path: Path) -> None:
    assert run(STOPPED + CODE, tmp_path).rstrip().endswith("KeyboardInterrupt")
