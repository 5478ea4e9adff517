"""Growth and none told apart: multipliers near the unit circle against the equation integrated, and what must grow."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from typer.testing import CliRunner

import epicyclic
from epicyclic.cli.main import app
from epicyclic.errors import ConvergenceError
from epicyclic.questions.contact_loss.branch_set import branch_set
from epicyclic.questions.contact_loss.solutions import Refinement, load_continuation, solution, with_stability
from epicyclic.questions.contact_loss.steady import contact_steady
from epicyclic.questions.contact_loss.sweep import contact_sweep
from epicyclic.questions.response import SteadyOptions, SweepOptions
from epicyclic.questions.response.response import response

# stiffness variation of the first order, and speed per natural frequency: the first range of parametric instability
SWING, SPEED = 0.045, 2.0


def size_of_multiplier(zeta: float) -> float:
    """Largest multiplier of x'' + 2 zeta x' + (1 + SWING cos(SPEED t)) x = 0 over a period."""

    def slope(t: float, z: Any) -> list[float]:
        return [z[1], -2 * zeta * z[1] - (1 + SWING * np.cos(SPEED * t)) * z[0]]

    period = 2 * np.pi / SPEED
    columns = [solve_ivp(slope, (0, period), start, rtol=1e-12, atol=1e-14).y[:, -1] for start in ([1.0, 0], [0, 1.0])]
    return float(np.abs(np.linalg.eigvals(np.array(columns).T)).max())


@pytest.mark.parametrize("above", [5e-4, 1e-5, -1e-5, -5e-4])
def test_closed_teeth_grow_above_one_by_however_little(made: Any, above: float) -> None:
    zeta = float(brentq(lambda ratio: size_of_multiplier(ratio) - 1 - above, 0.005, 0.02))
    system = made.single(variation=(SWING,), zeta=zeta, load=1130.0, backlash=5e-5)
    swept = contact_sweep(system, SweepOptions(relative_speed=[SPEED], unstable="report"))
    still = contact_steady(system, SteadyOptions(relative_speed=SPEED))
    assert not swept.contact_open.any()
    for found in (swept.sel(direction="up").isel(speed=0), still):
        # the integration's own tolerance
        assert found.largest_multiplier.item() == pytest.approx(1 + above, abs=1e-8)
        assert found.multiplier_error.item() < abs(above)
    assert swept.stable.values.all() == (above < 0)
    assert still.instability.item() == ("period doubling" if above > 0 else "stable")


def test_a_motion_between_two_folds_is_never_stable(made: Any) -> None:
    """Of one coordinate, damped, the branch that goes back between its folds is a saddle: its multiplier is above 1."""
    system = made.single(variation=(SWING,), zeta=0.008, load=1130.0, backlash=5e-5)
    refinement = Refinement(ready=response(system))
    (branch,) = (each for each in branch_set(refinement, np.array([0.8, 1.1])).segments if each.branch)
    speed = np.array([at.state.speed for at in branch.solutions])
    (upper, lower) = np.flatnonzero(np.diff(np.sign(np.diff(speed)))) + 1
    between = [with_stability(refinement, at).stability for at in branch.solutions[upper + 1 : lower]]
    assert len(between) > 10
    for found in between:
        assert found is not None
        assert abs(found.multiplier) > 1
        assert found.kind == "fold"


def test_teeth_that_part_have_the_multiplier_of_the_period_map_within_the_error(made: Any) -> None:
    """A motion near its fold, where the multiplier is near 1, by differences of the integrated equation."""
    system = made.single(variation=(SWING,), zeta=0.008, load=1130.0, backlash=5e-5)
    refinement = Refinement(ready=response(system))
    speed = 0.98
    branches = branch_set(refinement, np.array([0.8, speed, 1.1]))
    for crossing in branches.crossings[1]:
        at = with_stability(refinement, crossing.solution)
        assert at.stability is not None
        equation = made.equation(system, speed)
        y = at.state.y
        start = np.concatenate([y[0].sum(axis=0), -(speed * at.balance.omega @ y[1])]) * at.balance.modal.shapes[0, 0]
        scale, step = np.abs(start).max() * np.array([1.0, 6000.0]), 1e-6
        columns = []
        for i in (0, 1):
            kick = np.eye(2)[i] * scale * step
            ends = [equation.run(start + sign * kick, 1, rtol=1e-12, atol=1e-20)[:, -1] for sign in (1, -1)]
            columns.append((ends[0] - ends[1]) / (2 * step * scale[i]))
        size = np.abs(np.linalg.eigvals(np.array(columns).T)).max()
        assert abs(at.stability.multiplier) == pytest.approx(size, abs=2 * at.stability.error)


def test_what_the_linear_verb_refuses_is_not_called_stable(made: Any, tmp_path: Path) -> None:
    """A mode of the mean system that grows by less than 1e-3 a mesh cycle, teeth closed."""
    path = tmp_path / "soft.toml"
    options = ["--teeth", "21/39/99", "--planets", "4", "--module", "10 mm", "--helix", "7.5 deg"]
    assert (
        CliRunner().invoke(app, ["new", str(path), *options, "--power", "750 kW", "--speed", "1000 rpm"]).exit_code == 0
    )
    soft = {"carrier": "1e5 N/m", "ring": "1e5 N/m", "sun": "1e4 N/m"}
    overrides = {f"stages.main.{body}.support.radial": value for body, value in soft.items()}
    for contact_loss in (False, True):
        with pytest.raises(ConvergenceError, match="the mean system is unstable"):
            epicyclic.steady(path, overrides=overrides, contact_loss=contact_loss)
    # the balance itself, not asked whether the mean system is stable, has the growth of the mean system's eigenvalue
    system = epicyclic.assemble(epicyclic.load(path, overrides=overrides))
    refinement = Refinement(ready=response(system, asks_laws=True))
    found = load_continuation(refinement, 1.0, harmonics=16)
    at = solution(refinement, found.state.y, 1.0, balance=refinement.problem(16), harmonics=16)
    assert at is not None
    stability = with_stability(refinement, at).stability
    assert stability is not None
    n, inverse = len(system.M), np.linalg.inv(system.M)
    stiffness = system.mean_stiffness + system.Kg + system.Cskew
    damping = made.equation(system, 1.0).dampers() + (system.meshes.B * system.meshes.damping) @ system.meshes.B.T
    mean = np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ stiffness, -inverse @ (damping + system.G)]])
    rate = float(np.linalg.eigvals(mean).real.max())
    assert 0 < rate < 1e-3 * 288.75
    # the varying stiffness couples the whirl of soft bodies with nothing
    assert np.log(abs(stability.multiplier)) * 288.75 == pytest.approx(rate, rel=1e-3)
    assert not stability.stable
