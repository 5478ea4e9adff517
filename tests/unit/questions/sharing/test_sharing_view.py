"""What `sharing` says where a coefficient has no value."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

import epicyclic
from epicyclic.questions.sharing.views import findings, key_figures, tables
from epicyclic.show.series import largest_coefficients, unbroken
from epicyclic.show.views import findings_of

SPUR: dict[str, Any] = {"stages.main.helix_angle": "0 deg", "operation.torque.carrier": "3600 N m"}


def test_an_infinite_coefficient_is_told_as_undefined(one_stage: dict[str, Any]) -> None:
    """A spur set near a resonance, pulled open by the linear model: the forces of the ring mesh sum to less than 0."""
    errors = {"planet": {"run_out": "15 um", "position": {"y": "[20, 0, 0] um"}}}
    model = epicyclic.load(one_stage, SPUR | {"operation.speed.carrier": f"{1500 / 4.5} rpm", "deviations": errors})
    result = epicyclic.sharing(model, cycles=4, samples=32)
    assert np.isinf(result.system_load_sharing.sel(definition="simultaneous").item())
    (said,) = (text for text in json.loads(result.attrs["warnings"]) if "undefined" in text)
    assert "simultaneous of main/planet-ring/1, main/planet-ring/2, main/planet-ring/3" in said
    assert said.endswith("with method static the teeth part [load-sharing-undefined]")
    (table, *_) = tables(result)
    assert table.columns["simultaneous"][-1] == "undefined"
    assert ("undefined", f"load sharing, simultaneous: {unbroken('main/planet-ring/1')}") in key_figures(result)
    static = epicyclic.sharing(model, method="static", cycles=4)
    assert np.isfinite(static.system_load_sharing.values).all()


def test_a_planet_that_carries_too_little_leads_no_headline(one_stage: dict[str, Any]) -> None:
    """One pin out of place so that its planet carries least: cycle-peak counts what it lacks, the headline does not."""
    slow = {"stages.main.sun.support.radial": "5e9 N/m", "operation.speed.carrier": f"{300 / 4.5} rpm"}
    errors = {"deviations": {"planet": {"position": {"y": "[-20, 0, 0] um"}}}}
    result = epicyclic.sharing(epicyclic.load(one_stage, SPUR | slow | errors), cycles=4, samples=32)
    sizes = result.load_sharing.sel(definition="cycle-peak")
    signed = result.load_sharing.sel(definition="signed-overload")
    least = str(result.mesh.values[int(np.argmax(sizes.values))])
    assert float(signed.sel(mesh=least)) < 0.99  # the largest deviation is of a planet that carries too little
    for _, value, mesh in largest_coefficients(result):
        assert float(signed.sel(mesh=mesh)) > 1, (value, mesh)


def test_the_factor_while_turning_is_that_of_the_mesh_that_has_it() -> None:
    result = epicyclic.sharing("ren2021", cycles=2, samples=32)
    mean = result.load_sharing.sel(definition="mean-load")
    other = str(result.mesh.values[int(np.argmin(mean.values))])  # not the one of the largest mean
    coefficients = result.load_sharing.copy()
    coefficients.loc[{"definition": "mean-load-turning", "mesh": other}] = 1.9
    (text,) = (one.text for one in findings(result.assign(load_sharing=coefficients), {}) if "K_gamma" in one.text)
    assert ", 1.900 while turning" in text


def test_a_mesh_that_a_drag_alone_loads_is_not_judged() -> None:
    model = Path(__file__).parents[4] / "examples/models/ravigneaux.toml"
    drawn = {
        "deviations.main.long.position.y": "[40, 0, 0] um",
        "tolerance": {"deviations.main.long.position.y": "normal(0, 20 um)"},
    }
    for drag, shares in (("0 N m", False), ("-0.5 N m", False), ("-20 N m", True)):
        overrides = {**drawn, "operation.torque.large": drag}
        result = epicyclic.sharing(model, overrides=overrides, method="static")
        idle = np.array([name.startswith("main/large-long") for name in result["mesh"].values])
        assert np.isfinite(result["load_sharing"].sel(definition="mean-load").values[idle]).all() == shares, drag
        assert np.isfinite(result["load_sharing"].sel(definition="mean-load").values[~idle]).all()
        assert ("next to none" in result.attrs["warnings"]) != shares
        judged = next(one for one in findings_of({"": result}) if one.limit > 0)
        assert ("large" in judged.text) == shares
        rattling = result.assign(contact_lost=("mesh", idle))
        ((count, _),) = (one for one in key_figures(rattling) if "teeth part" in one[1])
        assert count == (f"{idle.sum()} of {idle.size}" if shares else f"none of {np.sum(~idle)}")
        (table, *_) = tables(rattling)
        assert table.columns["contact"][:-1] == [("lost" if shares else "no load") if one else "" for one in idle]
        drawn_k = epicyclic.tolerance(model, overrides=overrides, samples=256, effects="none")
        assert ("next to none" in drawn_k.attrs["warnings"]) != shares
        assert any("large-long" in str(pair) for pair in drawn_k["pair"].values) == shares
        assert np.isfinite(drawn_k["k_gamma_quantile"].sel(definition="mean-load").values).all()
