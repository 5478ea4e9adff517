"""A run that was stopped and goes on with another number of BLAS threads: the same bits."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import epicyclic
from epicyclic.errors import ModelError
from epicyclic.machine_code import numba_available

# 120 coordinates, whose matrices come from products that BLAS shares out: begins a run that is stopped after some
# segments, leaves a copy of it, and takes it up, or takes up the copy; compiled, then in NumPy.
RUN = """
import json, shutil, sys
how, base, kinds, here = json.loads(sys.argv[1])
sys.path.insert(0, here)
import numpy as np
from conftest import system_of
from test_sliders import group
from test_tables import curved
import epicyclic
from epicyclic.questions.transient import TransientOptions, integrators, transient
from epicyclic.questions.transient import scenario as run
from epicyclic.system.flank_laws import LawRows
from dataclasses import replace
random, n = np.random.default_rng(1), 120
A, turn, rows = random.normal(size=(n, n + 40)), random.normal(size=(n, n)), random.normal(size=(n, 6)) / np.sqrt(n)
spline = group(random.normal(size=(n, 2)) / np.sqrt(n), lag=1e-5)
system = system_of(
    np.diag(1 + random.random(n)), 1e5 * A @ A.T / n, rows, np.full(6, 1e6), force=100 * random.normal(size=n),
    variation=np.full((6, 2), 0.3 + 0j), backlash=1e-5, G=turn - turn.T, zeta=0.02, groups=(spline,),
)
system = replace(system, meshes=replace(system.meshes, laws=(LawRows(law=curved(2), rows=np.arange(2)),)))
def stop(done):
    if done > 0.5:
        raise KeyboardInterrupt
for kind in kinds:
    run._STEPS, run._PIECES = (200, 1) if kind == "compiled" else (10, 1)
    integrators.numba_available = lambda: kind == "compiled"
    folder = base + "-" + kind
    options = TransientOptions(cycles=4 if kind == "compiled" else 0.4, samples=16, folder=folder)
    if how == "begin":
        try:
            transient.transient(system, options, progress=stop)
            sys.exit("not stopped")
        except KeyboardInterrupt:
            shutil.copytree(folder, base + "-copy-" + kind)
    found = transient.transient(system, replace(options, resume=True))
    np.savez(folder + ".npz", **{name: found[name].values for name in found.data_vars})
"""


def run(how: str, folder: Path, kinds: list[str], threads: int) -> None:
    names = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
    # threads that wait for each other sleep soon: they would take the time of the processor meanwhile
    environment = os.environ | dict.fromkeys(names, str(threads)) | {"OPENBLAS_THREAD_TIMEOUT": "4"}
    options = json.dumps([how, str(folder), kinds, str(Path(__file__).parent)])
    subprocess.run([sys.executable, "-c", RUN, options], check=True, env=environment)


@pytest.fixture(scope="module")
def taken_up(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with the runs of one process with one thread, and their copies taken up by another with two."""
    folder = tmp_path_factory.mktemp("threads")
    kinds = ["compiled", "numpy"] if numba_available() else ["numpy"]
    run("begin", folder / "one", kinds, threads=1)
    for kind in kinds:
        kept, whole = (len(list((folder / f"{name}-{kind}").glob("0*.kept"))) for name in ("one-copy", "one"))
        assert 1 <= kept < whole
    run("resume", folder / "one-copy", kinds, threads=2)
    return folder


@pytest.mark.parametrize("kind", ["compiled", "numpy"])
def test_a_run_taken_up_with_other_threads(taken_up: Path, kind: str) -> None:
    if kind == "compiled":
        pytest.importorskip("numba")
    one, two = (np.load(taken_up / f"{name}-{kind}.npz") for name in ("one", "one-copy"))
    assert one["mesh_force"].shape[1] > 5
    assert float(np.abs(one["end_slider"]).max()) > 0
    for name in one.files:
        assert np.array_equal(one[name], two[name]), name


def test_another_model_is_refused(tmp_path: Path) -> None:
    """One number of the file, changed by more than rounding, where no option and no name has changed."""
    folder = tmp_path / "run"
    plain = epicyclic.transient("ren2021", cycles=2, samples=8, folder=folder)
    same = epicyclic.transient("ren2021", cycles=2, samples=8, folder=folder, resume=True)
    assert np.array_equal(plain.mesh_force, same.mesh_force)
    softer = {"stages.main.sun.support.radial": 2.0e8}
    with pytest.raises(ModelError, match="another model"):
        epicyclic.transient("ren2021", overrides=softer, cycles=2, samples=8, folder=folder, resume=True)
    numbers = folder / "model.numbers"
    numbers.write_bytes(numbers.read_bytes()[:1000])
    with pytest.raises(ModelError, match="not the numbers of a run"):
        epicyclic.transient("ren2021", cycles=2, samples=8, folder=folder, resume=True)
    numbers.unlink()
    (folder / "000000.kept").write_bytes(b"")
    with pytest.raises(ModelError, match="not a run that can be continued"):
        epicyclic.transient("ren2021", cycles=2, samples=8, folder=folder, resume=True)
