"""Resolving a train that needs no tooth contact imports none of it, nor SciPy: commands start quickly."""

from __future__ import annotations

import subprocess
import sys


def test_a_plain_train_is_resolved_without_tooth_contact() -> None:
    code = """
import sys
from epicyclic.resolve import load
load("ren2021")
heavy = {"scipy", "pint", "xarray", "epicyclic.tooth_contact.tooth", "epicyclic.tooth_contact.table"}
assert not heavy & set(sys.modules), heavy & set(sys.modules)
load("ren2021", {"stages.main.meshes.sun-planet.stiffness": "energy"})
assert "epicyclic.tooth_contact.tooth" in sys.modules
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
