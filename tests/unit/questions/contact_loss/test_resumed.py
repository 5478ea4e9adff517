"""A sweep with contact loss that is stopped among motions of two mesh cycles goes on to the same bits.

Inside a branch it goes on from its last point, to the tolerance of a step.
"""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from epicyclic.engine import run_folder as run_folder_module
from epicyclic.engine import workers
from epicyclic.engine.run_folder import run_folder
from epicyclic.questions.contact_loss import branch_set, continuation
from epicyclic.questions.contact_loss.sweep import contact_sweep
from epicyclic.questions.response import SweepOptions


@pytest.mark.parametrize("jobs", ["1", "2"])
def test_doubled_periods(made: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, jobs: str) -> None:
    monkeypatch.setenv("EPICYCLIC_JOBS", jobs)
    monkeypatch.setattr(workers, "_WORTH", {"fork": 0.0, "spawn": 0.0})
    monkeypatch.setattr(run_folder_module, "_EVERY", 0.0)
    system = made.single(variation=(0.045,), zeta=0.008, load=1130.0, backlash=5e-5)
    speeds = np.array([1.99, 2.0, 2.01])
    whole = contact_sweep(system, SweepOptions(relative_speed=speeds))
    assert (whole.motion == "period 2").any()
    for stop in range(1, 6):

        def interrupt(done: int, _: int, stop: int = stop) -> None:
            if done >= stop:
                raise KeyboardInterrupt

        folder, options = tmp_path / str(stop), {"relative_speed": speeds}
        with (
            pytest.raises(KeyboardInterrupt),
            run_folder(folder, system, verb="sweep", options=options, resume=False) as (given, kept),
        ):
            contact_sweep(given, SweepOptions(relative_speed=speeds), progress=interrupt, kept=kept)
        with run_folder(folder, system, verb="sweep", options=options, resume=True) as (given, kept):
            xr.testing.assert_identical(contact_sweep(given, SweepOptions(relative_speed=speeds), kept=kept), whole)


class Counted:
    """Calls of a function; before one of them the folder of the run is copied, as a kill leaves it, and all ends."""

    def __init__(self, patch: Any, module: Any, name: str, *, most: int = -1, run: Path = Path()) -> None:
        self.calls, self.most, self.run, self.before = 0, most, run, getattr(module, name)
        patch.setattr(module, name, self)

    def __call__(self, *given: Any, **more: Any) -> Any:
        if self.calls == self.most:
            shutil.copytree(self.run, self.run.with_name("killed"))
            raise KeyboardInterrupt
        self.calls += 1
        return self.before(*given, **more)


# Steps along branches, and branches that are entered, before which a run is killed.
@pytest.mark.parametrize(("steps", "entered"), [(12, -1), (70, -1), (-1, 1)])
def test_inside_a_branch(made: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, steps: int, entered: int) -> None:
    monkeypatch.setattr(run_folder_module, "_EVERY", 0.0)
    system = made.single(variation=(0.1, 0.1), zeta=0.03, load=1000.0, backlash=1e-5)
    options = SweepOptions(relative_speed=np.linspace(0.3, 1.3, 6), unstable="ignore")

    def swept(folder: str, resume: bool) -> xr.Dataset:
        with run_folder(tmp_path / folder, system, verb="sweep", options={}, resume=resume) as (given, kept):
            return contact_sweep(given, options, kept=kept)

    with monkeypatch.context() as patch:
        every = Counted(patch, continuation, "_advance")
        whole = contact_sweep(system, options)
    assert whole.sizes["fold"] >= 4  # two branches
    with monkeypatch.context() as patch:
        done = Counted(patch, continuation, "_advance", most=steps, run=tmp_path / "run")
        Counted(patch, branch_set, "_enter_branch", most=entered, run=tmp_path / "run")
        with pytest.raises(KeyboardInterrupt):
            swept("run", resume=False)
    with monkeypatch.context() as patch:
        left, scans = Counted(patch, continuation, "_advance"), Counted(patch, branch_set, "scan_closed_teeth")
        branches = Counted(patch, branch_set, "_enter_branch")
        again = swept("killed", resume=True)
    # a step may succeed at another length than before
    assert abs(done.calls + left.calls - every.calls) <= 2
    assert scans.calls == 0
    assert branches.calls == (2 if steps == 12 else 1)
    for curve in ("mesh_force_rms", "mesh_force_peak", "contact_open", "fold_frequency"):
        np.testing.assert_allclose(again[curve], whole[curve], rtol=1e-4, atol=1e-6, err_msg=curve)
    for words in ("status", "motion", "jumped"):
        assert (again[words] == whole[words]).all(), words
