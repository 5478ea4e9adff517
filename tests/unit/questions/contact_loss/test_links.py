"""Forces of links with contact loss: those of the linear response where contact stays, those of a record in time."""

from __future__ import annotations

import numpy as np
import pytest

import epicyclic
from epicyclic.questions.contact_loss import sweep_direction
from epicyclic.questions.contact_loss.shaft_orders import link_outputs
from epicyclic.questions.contact_loss.solutions import Refinement, load_continuation, solution
from epicyclic.questions.contact_loss.sweep_direction import IntegratedMotion, attractor, initial_state
from epicyclic.questions.response.response import response

LINK_MEASURES = (
    *("link_force_mean", "link_force_rms", "link_force_peak", "link_force_peak_to_peak"),
    *("bearing_force_mean", "bearing_force_rms", "bearing_force_peak"),
)
# with dampers, between bodies and to the housing that a frame turns against
DAMPERS = {
    "stages.main.planet.bearing.damping": {"radial": 1e7},
    "stages.main.carrier.support.damping": {"radial": 5e7},
}


@pytest.mark.parametrize(
    ("name", "changes"), [("wind-stage", {}), ("wind-stage", DAMPERS), ("ren2021", {})], ids=["wind", "dampers", "ren"]
)
def test_where_contact_stays_they_are_those_of_the_linear_response(name: str, changes: dict[str, object]) -> None:
    """Shaft orders and what stands still in the housing among them; extremes by samples, the linear ones refined."""
    system = epicyclic.assemble(epicyclic.load(name, overrides=changes))
    parting = epicyclic.steady(system, contact_loss=True)
    linear = epicyclic.steady(system, samples=parting.sizes["mesh_phase"])
    assert not parting["contact_lost"].any()
    assert parting["link_row"].values.tolist() == linear["link_row"].values.tolist()
    assert parting["bearing"].values.tolist() == linear["bearing"].values.tolist()
    for variable in ("link_force", *LINK_MEASURES):
        size = float(np.abs(linear[variable]).max())
        assert parting[variable].dims == linear[variable].dims
        np.testing.assert_allclose(parting[variable], linear[variable], rtol=2e-5, atol=2e-5 * size, err_msg=variable)


def test_a_record_in_time_has_those_of_the_balance(monkeypatch: pytest.MonkeyPatch) -> None:
    """Planet bearings with play follow their law; the record is taken where the balance would have polished it."""
    play = {"stages.main.planet.bearing.clearance": 10e-6}
    ready = response(epicyclic.assemble(epicyclic.load("wind-stage", overrides=play)), asks_laws=True)
    refinement, speed = Refinement(ready=ready), 0.5
    start = load_continuation(refinement, speed, harmonics=24)
    at = solution(refinement, start.state.y, speed, balance=refinement.problem(24), harmonics=24)
    assert at is not None
    monkeypatch.setattr(sweep_direction, "_solution_beside", lambda *_: None)
    monkeypatch.setattr(sweep_direction, "_LOOKS", (20,))
    found = attractor(refinement, initial_state(at), speed, harmonics=24)
    assert isinstance(found, IntegratedMotion)
    *_, links = link_outputs(ready, at.balance, at.state, ready.lines.tones)
    errors = {f"transmission_error_{kind}_peak_to_peak" for kind in ("rotation", "approach", "shaft")}
    assert found.measures.links.keys() == links.keys() == {*LINK_MEASURES, "link_force_factor", *errors}
    assert links["bearing_force_rms"].max() > 1e-3 * links["bearing_force_mean"].max()
    for name, values in links.items():
        size = np.abs(values).max()
        # 72 samples a cycle miss what a parabola sees between them
        near = 4e-2 if name.endswith(("peak_to_peak", "factor")) else 1e-3
        np.testing.assert_allclose(found.measures.links[name], values, rtol=near, atol=near * size, err_msg=name)
