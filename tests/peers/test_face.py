"""Coupling along the face: the finite elements of docs/theory/teeth/face.json solved again for one tooth (CalculiX)."""

from __future__ import annotations

import json
import shutil
from types import ModuleType

import numpy as np
import pytest

from epicyclic.teeth.compliance import face_coupling, tooth_compliance

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        shutil.which("ccx") is None, reason="the finite elements need CalculiX: apt install calculix-ccx"
    ),
]

NAME = "spur 25, narrow"


def test_table_and_kernel(face: ModuleType) -> None:
    found = face.solved(NAME)
    kept = json.loads(face.TARGET.read_text(encoding="utf-8"))[NAME]
    assert found["even"] == pytest.approx(kept["even"], rel=1e-3)
    np.testing.assert_allclose(found["coupling"], kept["coupling"], rtol=2e-3)
    # a tooth that tilts, and the kernel by itself
    tooth, width, count = tooth_compliance(face.form_of(kept["gear"])), kept["width"], kept["layers"]
    lengths = np.full(count, width / count)
    zeta = (np.arange(count) + 0.5) * lengths - width / 2
    ours = face_coupling(zeta, width, tooth.face_decay(width), lengths) * width
    linear = [zeta @ np.array(matrix) @ zeta for matrix in (ours, found["coupling"])]
    assert linear[0] == pytest.approx(linear[1], rel=0.05)
