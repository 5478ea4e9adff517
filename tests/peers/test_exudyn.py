"""Exudyn's generalised-alpha on our equation: another code's integrator finds the forces of harmonic balance."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from epicyclic.questions.response.measures import periodic
from epicyclic.questions.transient.equation import constant, motion

pytest.importorskip("exudyn", reason="Exudyn is not installed: pip install 'epicyclic[peers]'")
ROOT = Path(__file__).parents[2]


@pytest.fixture
def peers(monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.syspath_prepend(str(ROOT / "benchmarks"))
    yield importlib.import_module("peers")
    for name in ("peers", "baseline"):
        sys.modules.pop(name, None)


def test_generalised_alpha_settles_to_harmonic_balance(peers: Any) -> None:
    system, frequency = peers.problem(), 300.0
    speed = frequency / float(system.tones[0])
    known = periodic(system, relative_speed=speed)
    rms = known.force.std(axis=1)
    orders = np.fft.fftfreq(known.theta.size, 1 / known.theta.size)
    rate = np.fft.fft(known.displacement) * (2j * np.pi * frequency * orders) / known.theta.size
    start = np.stack([known.displacement[:, 0], rate.sum(axis=1).real])
    moving = motion(system, program=constant(speed), contact="linear")
    errors: list[float] = []
    for steps in (128, 256):
        found, _ = peers.exudyn_rms(moving, steps, 4, frequency, start)
        errors.append(float(np.abs(found - rms).max() / rms.max()))
    # it begins in the periodic state and stays there, but for its own error, of order two in the steps
    assert errors[1] < 3e-3
    assert 3.2 < errors[0] / errors[1] < 4.8
