"""How the branches of a branch set end: on closed teeth again, or cut where they wind through unstable motions."""

from __future__ import annotations

import json
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

import epicyclic
from epicyclic.questions.contact_loss import branch_set as module
from epicyclic.questions.contact_loss.branch_set import branch_set, scan_closed_teeth
from epicyclic.questions.contact_loss.continuation import Stepping, arclength_unit, branch, linear_start, solve
from epicyclic.questions.contact_loss.problem import dynamic_size
from epicyclic.questions.contact_loss.solutions import Refinement
from epicyclic.questions.contact_loss.sweep import contact_sweep
from epicyclic.questions.response import SweepOptions
from epicyclic.questions.response.response import response
from epicyclic.system.system import System

# Relative speeds from below the resonance to above it; a push of 400 N parts teeth about it, one of 210 N just does.
SPEEDS = np.linspace(0.3, 1.4, 12)


def pushed(made: Any, push: float = 400.0) -> Refinement:
    """A pair of gears whose resonance leans to lower speed where teeth part."""
    system: System = made.single(zeta=0.05, load=2000.0, push={1: push})
    return Refinement(ready=response(system, asks_laws=True))


@pytest.mark.parametrize("push", [400.0, 210.0])
def test_a_branch_that_is_back_on_closed_teeth_is_through(made: Any, push: float) -> None:
    found = branch_set(pushed(made, push), SPEEDS)
    assert [one.branch for one in found.segments] == [False, True, False]
    assert found.ended == found.cut == []
    points = found.segments[1].solutions
    assert [one.state.touching.all() for one in (points[0], points[len(points) // 2], points[-1])] == [
        True,
        False,
        True,
    ]
    assert points[-1].state.speed > points[-2].state.speed
    # it ends at its first closed point going up, before the next speed asked for, where the linear motions go on
    assert points[-1].state.speed < min(one.state.speed for one in found.segments[2].solutions)
    assert all(found.crossings)


def test_a_branch_that_goes_down_on_closed_teeth_is_through(made: Any) -> None:
    refinement = pushed(made)
    whole = branch_set(refinement, SPEEDS)
    branch = whole.segments[1]
    (middle,) = {part for part, one in zip(branch.parts, branch.solutions, strict=True) if one.backward}
    inside = [one for part, one in zip(branch.parts, branch.solutions, strict=True) if part == middle]
    start = inside[len(inside) // 2]
    trace = module._Trace(
        refinement=refinement,
        scan=scan_closed_teeth(refinement, SPEEDS),
        fixed=None,
        stepping=Stepping(),
        branches=module.BranchSet(speeds=SPEEDS, segments=[], crossings=[[] for _ in SPEEDS], ended=[]),
    )
    points, end = module._followed(trace, start.balance, start.harmonics, start.state)
    assert end == "through"
    # up to the upper fold, round it, and down to where teeth are just closed
    upper = max(inside, key=lambda one: one.state.speed).state.speed
    assert max(point.state.speed for point in points) == pytest.approx(upper, rel=1e-3)
    assert points[-1].tangent.speed < 0
    assert points[-1].state.touching.all()
    assert not any(point.state.touching.all() for point in points[:-1])
    # not on along the linear motions to the lowest speed
    assert points[-1].state.speed > 0.85


def unstable_parts(found: Any) -> list[bool]:
    """Whether the motion in the middle of each part between folds is unstable, the last point left out."""
    speed, stable = found.path_frequency.values, found.path_stable.values
    folds = [i for i, (a, b) in enumerate(pairwise(np.sign(np.diff(speed))), 1) if a != b]
    parts = np.split(np.arange(speed.size - 1), folds)
    return [not stable[part[len(part) // 2]] for part in parts]


def test_a_branch_that_winds_through_unstable_motions_is_cut(monkeypatch: pytest.MonkeyPatch) -> None:
    """Cut at the second unstable part in place of the sixteenth; the whole of it is through behind 22 folds."""
    system = epicyclic.assemble(epicyclic.load("ren2021"))
    system = replace(system, lines=tuple(one for one in system.lines if one.frequency in system.tones))
    monkeypatch.setattr(module, "_UNSTABLE_PARTS", 2)
    found = contact_sweep(
        system, SweepOptions(mesh_frequency=np.array([410.0, 455.0]), harmonics=16, unstable="report")
    )
    assert unstable_parts(found)[:3] == [False, True, True]
    assert found.sizes["fold"] == 3
    last = float(found.path_frequency[-1])
    assert last == pytest.approx(float(found.fold_frequency[-1]), abs=0.1)
    warnings = [text for text in json.loads(found.attrs["warnings"]) if "branch" in text]
    assert warnings == [
        f"a branch that winds through unstable motions was cut near {last:.4g} Hz: unstable motions may be missing "
        "[branch-cut]"
    ]
    # behind the cut only stable motions are looked for, and here is none
    assert found.status.values.tolist() == [["ok", "not converged"]] * 2


def test_a_speed_between_two_points_is_reached_along_the_branch(made: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where no interpolation counts, in lengths of a branch that has begun at motions a tenth as large."""
    refinement = pushed(made)
    balance = refinement.problem(8)
    start = solve(balance, linear_start(balance, 0.85), 0.85).state
    points = branch(
        balance,
        start,
        low=0.8,
        high=1.1,
        unit=arclength_unit(0.85, 0.85, start.y / 10),
        stepping=Stepping(points=60),
        score=lambda state, _: dynamic_size(state.y),
    )
    trace = module._Trace(
        refinement=refinement,
        scan=scan_closed_teeth(refinement, np.array([0.85])),
        fixed=8,
        stepping=Stepping(),
        branches=module.BranchSet(speeds=SPEEDS, segments=[], crossings=[], ended=[]),
    )
    monkeypatch.setattr(module, "_BETWEEN", 0.0)
    for before, after in list(pairwise(points))[::6]:
        a, b = before.state, after.state
        at = module._between(trace, before, after, (a.speed + b.speed) / 2, 8)
        assert at is not None
        assert np.linalg.norm(at.state.y - (a.y + b.y) / 2) < np.linalg.norm(a.y - b.y)
