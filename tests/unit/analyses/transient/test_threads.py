"""A run that was stopped and goes on with another number of BLAS threads: the same bits."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import epicyclic
from epicyclic.analyses.transient.kept import read_numbers
from epicyclic.errors import ModelError

# Begins a run that is stopped after some segments; takes it up; or runs it whole.
RUN = """
import json, sys
import epicyclic
from epicyclic.analyses.transient import integrators, run
how, folder, overrides, cycles, numba = json.loads(sys.argv[1])
run._STEPS, run._PIECES = 200, 1
if not numba:
    integrators.numba_available = lambda: False
system = epicyclic.assemble(epicyclic.load("ren2021", overrides=overrides))
def stop(done):
    if how == "begin" and done > 0.5:
        raise KeyboardInterrupt
try:
    found = epicyclic.transient(system, cycles=cycles, samples=8, folder=folder, resume=how == "resume", progress=stop)
    epicyclic.save_result(found, folder + ".nc")
except KeyboardInterrupt:
    assert how == "begin"
"""
TABLES = {f"stages.main.meshes.{pair}.stiffness": "contact" for pair in ("sun-planet", "planet-ring")}
SPLINE = {
    "stages.main.sun.support.radial": 1e8,
    "stages.main.sun.support.clearance": 2e-5,
    "stages.main.sun.support.friction": {"force": 300.0, "law": "coulomb"},
}


def run(how: str, folder: Path, overrides: Any, cycles: float, numba: bool, threads: int) -> None:
    names = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
    environment = os.environ | dict.fromkeys(names, str(threads))
    command = [sys.executable, "-c", RUN, json.dumps([how, str(folder), overrides, cycles, numba])]
    subprocess.run(command, check=True, env=environment)


@pytest.mark.parametrize(
    ("overrides", "cycles", "numba"),
    [(TABLES | SPLINE, 4.0, True), (SPLINE, 0.3, False)],
    ids=["compiled", "numpy"],
)
def test_a_run_taken_up_with_other_threads(tmp_path: Path, overrides: Any, cycles: float, numba: bool) -> None:
    if numba:
        pytest.importorskip("numba")
    run("begin", tmp_path / "one", overrides, cycles, numba, threads=1)
    shutil.copytree(tmp_path / "one", tmp_path / "four")
    assert 1 <= len(list((tmp_path / "one").glob("0*.npy"))) < 20
    run("resume", tmp_path / "one", overrides, cycles, numba, threads=1)
    run("resume", tmp_path / "four", overrides, cycles, numba, threads=4)
    one, four = (epicyclic.load_result(tmp_path / f"{name}.nc") for name in ("one", "four"))
    for name in one.data_vars:
        assert np.array_equal(one[name].values, four[name].values), name
    assert one.sizes["time"] > 2
    # what the folder is for: the equation itself is rounded differently where the threads are others
    run("begin", tmp_path / "other", overrides, cycles, numba, threads=4)
    own, other = (read_numbers(tmp_path / name / "equation.npz") for name in ("one", "other"))
    assert own.keys() == other.keys()


def test_another_model_is_refused(tmp_path: Path) -> None:
    """One number of the file, changed by more than rounding, where no option and no name has changed."""
    folder = tmp_path / "run"
    plain = epicyclic.transient("ren2021", cycles=2, samples=8, folder=folder)
    same = epicyclic.transient("ren2021", cycles=2, samples=8, folder=folder, resume=True)
    assert np.array_equal(plain.mesh_force, same.mesh_force)
    softer = {"stages.main.sun.support.radial": 2.0e8}
    with pytest.raises(ModelError, match="another model"):
        epicyclic.transient("ren2021", overrides=softer, cycles=2, samples=8, folder=folder, resume=True)
    numbers = folder / "equation.npz"
    numbers.write_bytes(numbers.read_bytes()[:1000])
    with pytest.raises(ModelError, match="not the numbers of a run"):
        epicyclic.transient("ren2021", cycles=2, samples=8, folder=folder, resume=True)
    numbers.unlink()
    (folder / "000000.npy").write_bytes(b"")
    with pytest.raises(ModelError, match="not a run that can be continued"):
        epicyclic.transient("ren2021", cycles=2, samples=8, folder=folder, resume=True)
