"""Stress in the tooth roots: an entry of docs/theory/teeth/root.json solved again (CalculiX)."""

from __future__ import annotations

import json
import shutil
from types import ModuleType

import pytest

from epicyclic.teeth.root_stress import fillet_stress, root_influence

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        shutil.which("ccx") is None, reason="the finite elements need CalculiX: apt install calculix-ccx"
    ),
]

NAME = "19 teeth, 25 deg"


def test_table_and_influence(root: ModuleType) -> None:
    kept = json.loads(root.TARGET.read_text(encoding="utf-8"))[NAME]
    influence = root_influence(root.root_form(NAME))
    for found, entry in zip(root.solved(NAME), kept, strict=True):
        assert found == pytest.approx(entry, rel=1e-3)
        right, left = fillet_stress(influence, entry["radius"])
        assert right.max() == pytest.approx(found["tension"], rel=0.01)
        assert left.min() == pytest.approx(found["compression"], rel=0.03)
