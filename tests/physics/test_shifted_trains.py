"""Shifted trains: ratio, speeds, torques, slip and efficiency of every state against the closed forms of Willis."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import epicyclic
from epicyclic.results.dataset import cases_of

MODELS = Path(__file__).parents[2] / "examples" / "models"


@cache
def found(name: str, verb: str = "check") -> dict[str, xr.Dataset]:
    return cases_of(getattr(epicyclic, verb)(MODELS / f"{name}.toml", overrides={"case": "all"}))


def of_members(check: xr.Dataset, what: str) -> dict[str, float]:
    return dict(zip(map(str, check["member"].values), check[what].values, strict=True))


def closed(check: xr.Dataset) -> dict[str, float]:
    """Torque through every closed coupling [N m]."""
    names = [str(name).removeprefix("couplings.") for name in check["path"].values]
    return {n: t for n, t in zip(names, check["path_torque"].values, strict=True) if not n.startswith("stages.")}


def slips(name: str) -> dict[str, dict[str, float]]:
    """Slip of every open coupling [rpm], as the shift table has it."""
    from epicyclic.show.views import tables_of

    whole = epicyclic.check(MODELS / f"{name}.toml", overrides={"case": "all"})
    table = next(one for one in tables_of(whole) if one.title.startswith("Couplings")).columns
    columns = {heading.split()[0]: values for heading, values in table.items() if "slip" in heading}
    return {
        case: {clutch: values[at] for clutch, values in columns.items() if values[at] == values[at]}
        for at, case in enumerate(table["case"])
    }


S, L, R = 27, 36, 84  # Ravigneaux: small sun, large sun, ring


def test_ravigneaux() -> None:
    # the small sun sees the ring through two planets: i0 = +R/S; the large one through one: i0 = -R/L
    ratio = {
        "first": R / S,
        "second": (R / S + R / L) / (1 + R / L),
        "third": 1.0,
        "fourth": 1 / (1 + L / R),
        "reverse": -R / L,
    }
    cases = found("ravigneaux")
    assert list(cases) == list(ratio)
    for name, check in cases.items():
        speed, torque = of_members(check, "speed"), of_members(check, "torque")
        assert speed["input"] / speed["main.ring"] == pytest.approx(ratio[name], rel=1e-12), name
        assert torque["main.ring"] == pytest.approx(-200 * ratio[name], rel=1e-9), name
        held = -200 + 200 * ratio[name]  # what holds the brake, or nothing where none is on
        brake = {"first": "main.carrier", "second": "main.large", "fourth": "main.large", "reverse": "main.carrier"}
        if name in brake:
            assert torque[brake[name]] == pytest.approx(held, rel=1e-9), name
        through = closed(check)
        if name == "third":  # small sun and carrier share as the torques of sun and carrier of one set: S to R - S
            assert through == pytest.approx({"C1": 200 * S / R, "C3": 200 * (1 - S / R)}, rel=1e-9)
        else:
            clutch = {"fourth": "C3", "reverse": "C2"}.get(name, "C1")
            assert through == pytest.approx({clutch: 200}, rel=1e-9)


def test_slip_of_the_open_clutches() -> None:
    n = 3000.0
    found_slips = slips("ravigneaux")
    assert found_slips["first"] == pytest.approx({"C2": -n * S / L - n, "C3": -n})
    carrier = n / (1 - (-L / S))  # second gear: w_S = n, w_L = 0, (w_S - w_C) / (w_L - w_C) = -L/S
    assert found_slips["second"] == pytest.approx({"C2": -n, "C3": carrier - n})
    assert found_slips["third"] == pytest.approx({"C2": 0}, abs=1e-9)
    assert found_slips["fourth"] == pytest.approx({"C1": n * (1 + L / S) - n, "C2": -n})
    assert found_slips["reverse"] == pytest.approx({"C1": -n * L / S - n, "C3": -n})


def test_simpson() -> None:
    s, r = 33, 75
    ratio = {"first": 2 + s / r, "second": 1 + s / r, "third": 1.0, "reverse": -r / s}
    brake = {"first": "rear.carrier", "second": "rear.sun", "reverse": "rear.carrier"}
    cases = found("simpson")
    assert list(cases) == list(ratio)
    for name, check in cases.items():
        speed, torque = of_members(check, "speed"), of_members(check, "torque")
        assert speed["input"] / speed["output"] == pytest.approx(ratio[name], rel=1e-12)
        assert torque["output"] == pytest.approx(-150 * ratio[name], rel=1e-9)
        if name in brake:
            assert torque[brake[name]] == pytest.approx(150 * (ratio[name] - 1), rel=1e-9)
    # the sun shaft carries what the ring of the front set does, by its teeth, in first and second
    assert closed(cases["first"])["sun_shaft"] == pytest.approx(-150 * s / r, rel=1e-9)
    assert closed(cases["third"]) == pytest.approx(
        {"C1": 150 * r / (r + s), "C2": 150 * s / (r + s), "output_front": 150, "output_rear": 0, "sun_shaft": 0},
        abs=1e-6,
    )


def test_hybrid() -> None:
    a, b, r = 36, 28, 84
    cases = found("hybrid")
    assert list(cases) == ["input_split", "compound_split", "fixed", "electric"]
    for name, check in cases.items():
        speed, torque = of_members(check, "speed"), of_members(check, "torque")
        engine, out = speed["engine"], speed["output"]
        # Willis of both sets
        assert a * (speed["split.sun"] - out) + r * (engine - out) == pytest.approx(0, abs=1e-9)
        assert b * (speed["range.sun"] - out) + r * (speed["range.ring"] - out) == pytest.approx(0, abs=1e-9)
        assert torque["engine"] * engine + torque["split.sun"] * speed["split.sun"] + torque["range.sun"] * speed[
            "range.sun"
        ] + torque["output"] * out == pytest.approx(0, abs=1e-6)
        electric = name == "electric"
        sun = 30 if electric else 140 * a / r  # torque of machine A, by the teeth of the ring
        machine_a = {"fixed": 0.0, "compound_split": sun + 60 * r / b}.get(name, sun)
        assert torque["split.sun"] == pytest.approx(machine_a, rel=1e-9)
        assert torque["engine"] == pytest.approx(sun * r / a, rel=1e-9)
        machine_b = 80 if electric else 60
        assert torque["output"] == pytest.approx(-sun * (1 + r / a) - machine_b * (1 + r / b), rel=1e-9)
        through = closed(check)
        if name == "compound_split":  # the ring of the range set needs what machine A gives it
            assert through["C2"] == pytest.approx(machine_b * r / b, rel=1e-9)
        if name == "fixed":  # it is held: what the sun of the split set does not need goes into the brake
            assert through["C2"] == pytest.approx(-sun, rel=1e-9)
        assert through["output_range"] == pytest.approx(machine_b * (1 + r / b), rel=1e-9)


# --- efficiency: what a mesh leaves of the power that rolls through it, in the frame of its carrier ------------------


def mesh_factors(result: xr.Dataset) -> dict[str, float]:
    """Pair -> 1 - friction x loss factor, of any of its meshes."""
    friction = json.loads(result.attrs["options"])["friction"]
    pairs = (str(mesh).rsplit("/", 1)[0] for mesh in result["mesh"].values)
    return {pair: 1 - friction * float(one) for pair, one in zip(pairs, result["loss_factor"].values, strict=True)}


def test_efficiency_of_the_ravigneaux_set() -> None:
    cases = found("ravigneaux", "efficiency")
    of = {name: float(result["train_efficiency"]) for name, result in cases.items()}
    eta = {pair.removeprefix("main/"): one for pair, one in mesh_factors(cases["first"]).items()}
    small, large, ring = eta["small-short"] * eta["short-long"], eta["large-long"], eta["long-ring"]
    assert of["first"] == pytest.approx(small * ring, abs=1e-12)  # the carrier at rest: in series
    assert of["reverse"] == pytest.approx(large * ring, abs=1e-12)
    assert of["third"] == 1  # nothing rolls
    assert of["fourth"] == pytest.approx((1 + L / R) / (1 + L / R / (large * ring)), abs=1e-12)
    # second: the small sun drives, the large one is held: both it and the ring take power in the frame of the carrier
    carrier = 1 / (1 + L / S)
    w_small, w_large, w_ring = 1 - carrier, -carrier, L / R * carrier
    matrix = np.array(
        [[1.0, 1.0], [w_ring / ring, w_large / large]]
    )  # torques of ring and large sun of one at the small
    torque = np.linalg.solve(matrix, [-1.0, -small * w_small])
    assert of["second"] == pytest.approx(-torque[0] * (carrier + w_ring), abs=1e-12)


def test_efficiency_of_the_simpson_set() -> None:
    s, r = 33, 75
    cases = found("simpson", "efficiency")
    of = {name: float(result["train_efficiency"]) for name, result in cases.items()}
    eta = mesh_factors(cases["first"])
    front, rear = (eta[f"{stage}/sun-planet"] * eta[f"{stage}/planet-ring"] for stage in ("front", "rear"))
    assert of["first"] == pytest.approx((1 + front * s / r + front * rear) / (2 + s / r), abs=1e-12)
    assert of["second"] == pytest.approx((1 + front * s / r) / (1 + s / r), abs=1e-12)
    assert of["third"] == pytest.approx(1, abs=1e-12)
    assert of["reverse"] == pytest.approx(rear, abs=1e-12)


def test_efficiency_of_the_electric_state() -> None:
    a, b, r, out = 36, 28, 84, 500.0
    result = found("hybrid", "efficiency")["electric"]
    eta = mesh_factors(result)
    split, range_ = (eta[f"{stage}/sun-planet"] * eta[f"{stage}/planet-ring"] for stage in ("split", "range"))
    given = 30 * (1 + r / a) * out + 80 * (1 + r / b) * out
    taken = 30 * (1 + split * r / a) * out + 80 * (1 + range_ * r / b) * out
    assert float(result["train_efficiency"]) == pytest.approx(taken / given, abs=1e-12)


def test_clutches_that_share_a_torque_by_stiffness_are_named() -> None:
    closed_all: dict[str, object] = {"operation.open": [], "operation.held": []}
    train = epicyclic.load(MODELS / "ravigneaux.toml", closed_all)
    assert train.kinematics.undetermined == ("C1", "C2", "C3")
    assert any(text.endswith("[torque-undetermined]") for text in train.warnings)
    for case in ("first", "third"):
        assert epicyclic.load(MODELS / "ravigneaux.toml", {"case": case}).kinematics.undetermined == ()
