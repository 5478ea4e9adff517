"""Interfaces and the reduction to them, on a ring of bricks."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Literal

import numpy as np
import pytest
import scipy.linalg

from epicyclic.bodies.joined_body import Interface, axisymmetric, interface_shape, reduced, turning_with_frame
from epicyclic.bodies.reduced_body import Array, BodyFacts, ReducedBody, checked, rigid_motion, rigid_rows
from epicyclic.errors import ModelError

Spider = Literal["average", "rigid", "nodes"]
Checked = tuple[ReducedBody, BodyFacts]
POINT = np.array([0.16, 0.01, -0.02])


def places(spider: Spider, count: int = 4) -> list[Interface]:
    """The four nodes of every other section of the ring of 8 bricks, or of fewer."""
    first = [4 * (8 // count) * i + 1 for i in range(count)]
    return [Interface(name=f"p{i}", nodes=tuple(range(n, n + 4)), spider=spider) for i, n in enumerate(first)]


def squares(body: ReducedBody) -> Array:
    k, m = (one if isinstance(one, np.ndarray) else one.toarray() for one in (body.K, body.M))
    return np.asarray(scipy.linalg.eigh(k, m, eigvals_only=True))


@pytest.mark.parametrize("spider", ["nodes", "average"])
def test_all_modes_are_the_whole_body(few: Checked, spider: Spider) -> None:
    body, there = reduced(few[0], places(spider), 96 - 12 * 4 if spider == "nodes" else 96 - 6 * 4, "few")
    assert squares(body)[6:] == pytest.approx(squares(few[0])[6:], rel=1e-8)
    points = [(1,), (2,), (3,), (4,)]
    kept = [(1, 2, 3, 4), (9, 10, 11, 12), (17, 18, 19, 20), (25, 26, 27, 28)]
    assert [one.nodes for one in there] == (kept if spider == "nodes" else points)


def test_frequencies_come_down_with_the_modes(few: Checked) -> None:
    whole = squares(few[0])[6:20]
    worst = [
        np.max(squares(reduced(few[0], places("average"), modes, "few")[0])[6:20] / whole - 1) for modes in (2, 8, 20)
    ]
    assert worst[0] > 5 * worst[1] > 25 * worst[2] > 0


def test_a_rigid_spider_is_the_elimination_of_its_nodes(few: Checked) -> None:
    body, there = reduced(few[0], [*places("rigid", 2), *places("nodes")[1::2]], 48, "few")
    own = [one for i, one in enumerate(few[0].dof_node) if not (one <= 4 or 17 <= one <= 20)]
    lift = np.zeros((96, len(own) + 12))
    lift[np.flatnonzero(np.isin(few[0].dof_node, own)), np.arange(len(own))] = 1
    for k, one in enumerate(places("rigid", 2)):
        at = np.flatnonzero(np.isin(few[0].dof_node, one.nodes))
        centre = few[0].places(np.array(one.nodes)).mean(axis=0)
        lift[at, len(own) + 6 * k : len(own) + 6 * k + 6] = rigid_rows(
            few[0].places(few[0].dof_node[at]), few[0].dof_dir[at], centre
        )
    k, m = (lift.T @ (one @ lift) for one in (few[0].K, few[0].M))
    want = scipy.linalg.eigh(k, m, eigvals_only=True)
    assert squares(body)[6:] == pytest.approx(want[6:], rel=1e-8)
    assert [one.nodes for one in there] == [(1,), (2,), (9, 10, 11, 12), (25, 26, 27, 28)]
    assert body.node_id.tolist() == [1, 2, 9, 10, 11, 12, 25, 26, 27, 28]
    assert np.abs(body.node_xyz[0] - few[0].node_xyz[:4].mean(axis=0)).max() < 1e-15


@pytest.mark.parametrize("spider", ["average", "rigid", "nodes"])
def test_the_mass_of_a_reduced_body_is_that_of_the_whole(few: Checked, spider: Spider) -> None:
    body, there = reduced(few[0], places(spider), 5, "few")
    _, facts = checked(body, "few")
    assert facts.mass == pytest.approx(few[1].mass, rel=1e-9)
    assert facts.inertia == pytest.approx(few[1].inertia, abs=1e-9)
    for one in there:
        shape = interface_shape(body, one, "few")
        point = body.places(np.array(one.nodes)).mean(axis=0)
        assert shape @ facts.rigid == pytest.approx(rigid_rows(np.tile(point, (6, 1)), np.arange(1, 7)), abs=1e-9)


def test_an_average_moves_and_loads_as_its_point(few: Checked) -> None:
    body = few[0]
    shape = interface_shape(body, Interface(name="p", nodes=(1, 2, 3, 4), point=POINT), "few")
    at_point = rigid_rows(np.tile(POINT, (6, 1)), np.arange(1, 7))
    assert shape @ rigid_motion(body) == pytest.approx(at_point, abs=1e-12)
    load = np.array([3.0, -2.0, 1.0, 0.4, 0.5, -0.6])  # force and moment at the point: their resultant at the origin
    assert rigid_motion(body).T @ (shape.T @ load) == pytest.approx(at_point.T @ load, abs=1e-12)
    assert np.abs(shape[:, 12:]).max() == 0  # no other node


def test_two_nodes_do_not_see_the_rotation_about_their_line(few: Checked) -> None:
    body = few[0]
    line = Interface(name="line", nodes=(1, 3))  # along x
    shape = interface_shape(body, line, "few")
    seen = shape @ rigid_motion(body)
    assert np.abs(seen[3]).max() < 1e-12  # rx
    assert seen[5, 5] == pytest.approx(1)
    with pytest.raises(ModelError, match="few: line: the average does not see all rotations"):
        reduced(body, [line, *places("nodes")[1:]], 0, "few")


def test_a_slanted_line_is_seen_across_it(few: Checked) -> None:
    body = few[0]
    line = Interface(name="line", nodes=(5, 8))
    ends = body.places(np.array(line.nodes))
    along = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
    assert np.abs(along).min() > 0.1
    seen = interface_shape(body, line, "few") @ rigid_motion(body)
    assert seen[3:, 3:] == pytest.approx(np.eye(3) - np.outer(along, along), abs=1e-12)


def test_points_with_rotations_are_averaged_too(few: Checked) -> None:
    body, there = reduced(few[0], places("average"), 3, "few")
    both = Interface(name="both", nodes=there[0].nodes + there[1].nodes)
    seen = interface_shape(body, both, "few") @ rigid_motion(body)
    middle = body.places(np.array(both.nodes)).mean(axis=0)
    assert seen == pytest.approx(rigid_rows(np.tile(middle, (6, 1)), np.arange(1, 7)), abs=1e-12)


def test_the_centre_of_a_body_off_its_axes(few: Checked) -> None:
    away = np.array([0.3, -0.2, 0.5])
    _, facts = checked(replace(few[0], node_xyz=few[0].node_xyz + away), "few")
    assert facts.centre == pytest.approx(away)
    assert facts.inertia == pytest.approx(few[1].inertia, abs=1e-9)


def test_one_node_with_rotations_is_its_own_interface(few: Checked) -> None:
    body, there = reduced(few[0], places("average"), 3, "few")
    assert interface_shape(body, there[1], "few") == pytest.approx(np.eye(6, len(body.dof_dir), 6), abs=1e-12)
    higher = body.places(np.array(there[1].nodes))[0] + np.array([0, 0, 0.1])
    beside = interface_shape(body, replace(there[1], point=higher), "few")
    assert beside[0, 6 + 4] == pytest.approx(0.1)  # x from ry


@pytest.mark.parametrize(
    ("interfaces", "modes", "words"),
    [
        ([*places("average"), Interface(name="q", nodes=(1, 40))], 3, "few: p0, .*q: a node in two interfaces"),
        ([Interface(name="q", nodes=(1, 400))], 3, "few: q = 400: no such node"),
        ([Interface(name="q", nodes=())], 3, "few: q: no nodes with coordinates"),
        ([Interface(name="q", nodes=(1, 3), spider="nodes")], 3, "few: q: the interfaces do not hold the body"),
        (places("average"), 73, "few: modes = 73: not so many modes; allowed: 0 to 72"),
    ],
)
def test_what_is_refused(few: Checked, interfaces: list[Interface], modes: int, words: str) -> None:
    with pytest.raises(ModelError, match=words):
        reduced(few[0], interfaces, modes, "few")


# --- turning ---------------------------------------------------------------------------------------------------------


def test_a_rigid_body_that_turns_with_its_frame_has_the_terms_of_the_conventions(few: Checked) -> None:
    body, _ = reduced(turning_with_frame(few[0], "few"), places("average"), 4, "few")
    rigid, facts = rigid_motion(body), few[1]
    coriolis, centrifugal = rigid.T @ body.G1 @ rigid, rigid.T @ body.KG1 @ rigid
    mass, polar, across = facts.mass, facts.inertia[2, 2], facts.inertia[0, 0]
    assert coriolis[0, 1] == pytest.approx(-2 * mass)
    assert coriolis[3, 4] == pytest.approx(polar - 2 * across)  # I_p w - 2 I_d Omega, both of the frame
    assert centrifugal[0, 0] == pytest.approx(-mass)
    assert centrifugal[2, 2] == pytest.approx(0, abs=1e-9)


def test_the_pattern_of_bricks(bricks: Checked) -> None:
    body = axisymmetric(bricks[0], 32, 31, (1, 2, 3, 4, 21, 22, 23, 24), "bricks")
    assert body.D is not None
    assert body.shape is not None
    waves = np.linalg.eigvals(body.D).imag
    assert np.abs(waves - np.round(waves)).max() < 1e-8
    assert set(np.round(np.abs(waves))) == set(range(6))
    assert len(body.M) in (30, 31)
    assert np.abs(body.D @ body.K - body.K @ body.D).max() < 1e-8 * body.K.max()
    here = interface_shape(body, Interface(name="a", nodes=(1, 2, 3, 4)), "bricks")
    there = interface_shape(body, Interface(name="b", nodes=(21, 22, 23, 24)), "bricks")
    angle = 5 * 2 * math.pi / 32
    turn = np.array([[math.cos(angle), -math.sin(angle), 0], [math.sin(angle), math.cos(angle), 0], [0, 0, 1]])
    own = np.kron(np.eye(2), turn.T) @ there
    assert here @ scipy.linalg.expm(angle * body.D) == pytest.approx(own, abs=1e-8 * np.abs(own).max())
    assert np.abs(here - own).max() > 0.1 * np.abs(own).max()


def test_a_pattern_that_is_none(bricks: Checked) -> None:
    body = axisymmetric(bricks[0], 32, 20, (1, 2, 3, 4), "bricks")
    assert body.D is not None
    mixed = body.D.copy()
    mixed[6, 12] += 1e-3
    mixed[12, 6] -= 1e-3
    for wrong, words in (
        (mixed, "D: does not commute with K"),
        (body.D + 1e-3 * np.eye(20), "D: does not commute with M"),
    ):
        with pytest.raises(ModelError, match=words):
            checked(replace(body, D=wrong), "bricks")
    with pytest.raises(ModelError, match="q: reduced already"):
        reduced(body, [Interface(name="q", nodes=(1, 2, 3, 4))], 2, "bricks")


def test_what_is_no_axisymmetric_body(bricks: Checked) -> None:
    body = bricks[0]
    soft = body.K.copy()
    soft.data[:] *= 1 + 1e-6 * (np.arange(soft.nnz) < 200)
    for given, sectors, modes, words in (
        (body, 31, 20, "node_xyz = .*: no node where a turn by one of 31 sectors takes it"),
        (replace(body, K=0.5 * (soft + soft.T)), 32, 20, "K: a turn by one of 32 sectors changes the matrix"),
        (body, 8, 60, "modes = 4 waves: modes with more waves than the sectors tell apart; allowed: less than 4"),
    ):
        with pytest.raises(ModelError, match=words):
            axisymmetric(given, sectors, modes, (1,), "bricks")
    with pytest.raises(ModelError, match="dof_dir: rotations or modes"):
        turning_with_frame(reduced(body, [Interface(name="q", nodes=(1, 2, 3, 4))], 2, "bricks")[0], "bricks")
