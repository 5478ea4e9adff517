"""Rings: the kept one, one of bricks assembled here, and the mesh of CalculiX where that is installed."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
import reduced_ring
from tests.unit.bodies.bricks import brick_ring

from epicyclic.bodies.files import read_body
from epicyclic.bodies.reduced_body import BodyFacts, ReducedBody, checked

Checked = tuple[ReducedBody, BodyFacts]


@pytest.fixture(scope="session")
def kept() -> Checked:
    """The reduced ring of the repository, 84 coordinates."""
    return read_body(reduced_ring.KEPT, path="bodies.ring")


@pytest.fixture(scope="session")
def bricks() -> Checked:
    """A ring of 32 bricks, 384 coordinates, sparse."""
    return checked(brick_ring(32), "bricks")


@pytest.fixture(scope="session")
def few() -> Checked:
    """A ring of 8 bricks, 96 coordinates, sparse."""
    return checked(brick_ring(8), "few")


@pytest.fixture(scope="session")
def calculix(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Checked]:
    """The whole ring of 48 bricks as CalculiX writes it."""
    if shutil.which("ccx") is None:
        pytest.skip("the mesh needs CalculiX: apt install calculix-ccx")
    file = reduced_ring.solved(tmp_path_factory.mktemp("ring"))
    return file, read_body(file, units="kg m s", path="bodies.ring")
