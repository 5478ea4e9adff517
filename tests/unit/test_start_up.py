"""What a command imports, and when: no more than it needs, with the collector of cycles at rest."""

from __future__ import annotations

import json
import subprocess
import sys
from functools import cache
from typing import Any

import pytest

RUN = """
import gc, json, sys
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
facts = {{"modules": list(sys.modules), "collected": collected, "on": gc.isenabled(), "frozen": gc.get_freeze_count()}}
json.dump(facts, sys.stderr)
"""
# what only other verbs, other models, or a file or a report need
HEAVY = {
    *("numba", "pint", "plotly", "pymoo", "h5py", "h5netcdf", "scipy.optimize", "scipy.sparse", "scipy.interpolate"),
    *("distributed", "zarr", "dask.array"),
    *("epicyclic.teeth.compliance", "epicyclic.audits.audit"),
    *("epicyclic.questions.contact_loss.sweep", "epicyclic.show.report"),
}


@cache
def facts_of(*arguments: str) -> dict[str, Any]:
    """What a process that runs a command has imported, when its collector ran, and whether it is at work behind it."""
    command = [sys.executable, "-c", RUN.format(arguments=list(arguments))]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    found: dict[str, Any] = json.loads(done.stderr)
    return found


def test_a_result_is_shown_with_the_views_of_its_question_alone() -> None:
    modules = set(facts_of("check", "ren2021")["modules"])
    views = {name for name in modules if name.endswith(".views")} - {"epicyclic.show.views"}
    assert views == {"epicyclic.questions.check.views"}
    assert "plotly" not in modules


@pytest.mark.parametrize("name", ["ren2021", "encased-differential"])
def test_a_sweep_of_linear_contact_imports_only_what_it_needs(name: str) -> None:
    modules = set(facts_of("sweep", name, "--points", "2")["modules"])
    assert HEAVY & modules == set()
    assert "xarray" in modules


def test_a_computing_process_of_the_page_starts_without_what_some_views_need() -> None:
    """Together they took two fifths of its start."""
    code = "import sys, epicyclic.cockpit.computing.compute; print(*sys.modules)"
    modules = set(
        subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    )
    assert "xarray" in modules
    heavy = {"scipy.interpolate", "scipy.optimize", "scipy.signal", "scipy.stats", "scipy.ndimage", "plotly", "nicegui"}
    assert modules & heavy == set()


@pytest.mark.parametrize("verb", ["static", "sharing"])
def test_neither_units_nor_image_filters_are_imported_for_a_table(verb: str) -> None:
    """xarray tries by import whether labels are arrays of pint, which takes 0.1 s."""
    modules = set(facts_of(verb, "ren2021")["modules"])
    assert modules & {"pint", "scipy.ndimage"} == set()


def test_the_collector_rests_while_the_model_rooms_come_and_works_then() -> None:
    facts = facts_of("check", "ren2021")
    assert facts["on"]
    assert facts["frozen"] > 10_000
    assert "within" not in facts["collected"]
    assert "after" in facts["collected"]


def test_the_collector_works_after_a_command_that_is_no_verb() -> None:
    facts = facts_of("systems")
    assert facts["on"]
    assert facts["frozen"] > 1_000
