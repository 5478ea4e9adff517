"""Resolving a train that needs no tooth contact imports none of it, nor SciPy: commands start quickly."""

from __future__ import annotations

import subprocess
import sys


def test_a_plain_train_is_resolved_without_tooth_contact() -> None:
    code = """
import sys
from epicyclic.train.resolution import load
load("ren2021")
heavy = {"scipy", "pint", "xarray", "epicyclic.teeth.compliance", "epicyclic.teeth.loaded_contact"}
assert not heavy & set(sys.modules), heavy & set(sys.modules)
load("ren2021", {"stages.main.meshes.sun-planet.stiffness": "energy"})
assert "epicyclic.teeth.compliance" in sys.modules
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
