"""What a command imports, and when: no more than it needs, with the collector of cycles at rest."""

from __future__ import annotations

import subprocess
import sys

import pytest

RUN = """
import gc, sys
collected = []
def note(phase, info):
    rooms = sys.modules.get("epicyclic.engine.source")
    collected.append("before" if rooms is None else "after" if hasattr(rooms, "train_of") else "within")
gc.callbacks.append(note)
from epicyclic.__main__ import main
sys.argv[1:] = {arguments!r}
try:
    main()
except SystemExit as end:
    assert not end.code, end.code
"""
# what only other verbs, other models, or a file or a report need
HEAVY = """
heavy = {"numba", "pint", "plotly", "pymoo", "h5py", "h5netcdf", "scipy.optimize", "scipy.sparse", "scipy.interpolate"}
heavy |= {"distributed", "zarr", "dask.array"}
heavy |= {"epicyclic.teeth.compliance", "epicyclic.audits.audit"}
heavy |= {"epicyclic.questions.contact_loss.sweep", "epicyclic.show.report"}
assert not heavy & set(sys.modules), heavy & set(sys.modules)
assert "xarray" in sys.modules
"""


def fault(code: str, *arguments: str) -> str:
    """What a process said in which an assertion failed behind a command; empty where all of them hold."""
    code = RUN.format(arguments=list(arguments)) + code
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    return done.stderr or "failed" if done.returncode else ""


def test_a_result_is_shown_with_the_views_of_its_question_alone() -> None:
    code = """
views = {name for name in sys.modules if name.endswith(".views")} - {"epicyclic.show.views"}
assert views == {"epicyclic.questions.check.views"}, views
assert "plotly" not in sys.modules
"""
    assert fault(code, "check", "ren2021") == ""


@pytest.mark.parametrize("name", ["ren2021", "encased-differential"])
def test_a_sweep_of_linear_contact_imports_only_what_it_needs(name: str) -> None:
    assert fault(HEAVY, "sweep", name, "--points", "2") == ""


def test_the_collector_rests_while_the_model_rooms_come_and_works_then() -> None:
    code = """
assert gc.isenabled() and gc.get_freeze_count() > 10_000
assert "within" not in collected and "after" in collected, len(collected)
"""
    assert fault(code, "modes", "ren2021") == ""


def test_the_collector_works_after_a_command_that_is_no_verb() -> None:
    assert fault("assert gc.isenabled() and gc.get_freeze_count() > 1_000", "systems") == ""
