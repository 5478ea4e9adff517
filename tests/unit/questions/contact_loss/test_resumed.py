"""A sweep with contact loss that is stopped among motions of two mesh cycles goes on to the same bits."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from epicyclic.engine import run_folder as run_folder_module
from epicyclic.engine import workers
from epicyclic.engine.run_folder import run_folder
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
