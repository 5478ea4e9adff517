"""What results say of themselves, in terminal, report and page: where teeth part, largest forces, what moves."""

from __future__ import annotations

import tomllib
from functools import cache

import numpy as np
import pytest
import xarray as xr

import epicyclic
from epicyclic.cockpit.computing.job_kinds import JOBS
from epicyclic.document.document import drive_text
from epicyclic.show.views import findings_of


def contact_sweep(opened: list[list[bool]], failed: int = 0) -> xr.Dataset:
    """A sweep with contact loss from 50 to 150 %, of one mesh that opens as `opened` (direction, speed) has it."""
    apart = np.array(opened, dtype=float)[:, None, :]
    speed = np.linspace(0.5, 1.5, apart.shape[2])
    dims = ("direction", "mesh", "speed")
    peak = np.array(np.broadcast_to(1000 * (1 + speed), apart.shape))
    status = np.array(["ok"] * apart[:, 0].size, dtype=object)
    status[:failed] = "no motion"
    peak.flat[:failed] = np.nan
    return xr.Dataset(
        {
            "mesh_force_peak": (dims, peak),
            "mesh_force_minimum": (dims, 0.1 * peak),
            "contact_open": (dims, apart),
            "status": (("direction", "speed"), status.reshape(2, -1)),
        },
        coords={"speed": speed, "mesh": ["main/sun-planet/1"], "direction": ["up", "down"]},
        attrs={"verb": "contact_sweep"},
    )


@pytest.mark.parametrize(
    ("up", "down", "tone", "words"),
    [
        ([0, 0, 0, 0, 0], [0, 0, 0, 0, 0], "good", "No tooth loses contact from 50 to 150 % of the operating speed"),
        ([0, 0, 0, 1, 1], [0, 0, 0, 1, 1], "caution", "Teeth part at 125 to 150 % of the operating speed; largest"),
        ([1, 0, 1, 0, 0], [1, 0, 0, 0, 0], "bad", "at 50 %, 100 % of the operating speed, not at the same speeds up"),
    ],
)
def test_ranges_in_which_teeth_part(up: list[bool], down: list[bool], tone: str, words: str) -> None:
    (found,) = findings_of({"": contact_sweep([up, down], failed=3)})
    assert found.tone == tone
    assert words in found.text
    assert "largest force 2.5 kN at 150 %, sun" in found.text
    assert found.text.endswith(" 3 points have no motion.")


def test_a_mesh_on_its_far_flank_counts_by_the_size_of_its_force() -> None:
    result = contact_sweep([[False] * 5, [False] * 5], failed=1)
    result["mesh_force_minimum"] = -4 * result.mesh_force_peak[..., ::-1].assign_coords(speed=result.speed)
    (found,) = findings_of({"": result})
    assert "largest force 10 kN at 50 %, sun" in found.text
    assert found.text.endswith(" 1 point has no motion.")


@cache
def motion() -> xr.Dataset:
    return epicyclic.transient("ren2021", cycles=2)


def test_the_largest_force_of_a_motion_and_when() -> None:
    result = motion()
    (found,) = findings_of({"": result})
    peak = result.mesh_force_peak.values
    when = 1e3 * float(result.mesh_force_peak_time.values[peak.argmax()])
    assert f"{peak.max() / 1e3:.4g} kN" in found.text
    assert f"after {when:.4g} ms" in found.text
    assert found.tone == "good"
    assert found.text.endswith("; no mesh loses contact.")
    lost = result.copy()
    lost["contact_lost"] = lost["contact_lost"] | (np.arange(lost.sizes["mesh"]) < 2)
    (found,) = findings_of({"": lost})
    assert found.tone == "caution"
    assert f"2 of {lost.sizes['mesh']} meshes lose contact." in found.text


def test_the_losses_of_the_meshes_and_where_most_is_lost() -> None:
    result = epicyclic.efficiency("ren2021")
    (found,) = findings_of({"": result})
    loss = {pair: 0.0 for pair in ("sun-planet", "planet-ring")}
    for name, value in zip(result.mesh.values, result.mesh_power_loss.values, strict=True):
        loss[str(name).split("/")[1]] += float(value)
    pair = max(loss, key=lambda name: loss[name])
    assert f"{100 * loss[pair] / sum(loss.values()):.0f} % of it in {pair}." in found.text


def test_what_moves_a_mode_most() -> None:
    result = epicyclic.sensitivity("lin1999-n3").isel(path=slice(None, None, -1))  # the verb has the largest first
    (found,) = findings_of({"": result})
    largest = np.abs(result.sensitivity.values[:, result.ranked_by.values.astype(bool)]).max(axis=1)
    assert found.text.startswith(f"{result.path.values[largest.argmax()]} moves {result.attrs['subject']} most: ")
    assert f"{largest.max():.6g} % per" in found.text.replace("-", "")
    still = result.copy()
    still["sensitivity"] = 0.0 * still["sensitivity"]
    (found,) = findings_of({"": still})
    assert found.text == f"No number of the model moves {result.attrs['subject']}."


def test_the_page_says_what_the_terminal_says() -> None:
    frame, result = JOBS["transient"].run(tomllib.loads(drive_text("ren2021")), {}, {"cycles": 2.0}, lambda *_: None)
    (found,) = findings_of({"": result})
    assert frame.head["job"]["text"] == found.text


def test_the_mesh_that_varies_most_and_the_phases() -> None:
    result = epicyclic.stiffness("ren2021")
    (found,) = findings_of({"": result})
    history = result.mesh_stiffness.transpose("mesh", "mesh_phase").values
    swing = np.ptp(history, axis=1) / history.mean(axis=1)
    assert f"by {100 * swing.max():.3g} % of its mean {1e-6 * history.mean(axis=1)[swing.argmax()]:.4g} N" in found.text
    leads = np.unique(np.round(result.phase_lead.values, 6))
    assert f"phases of the meshes are {leads[0]:.3g}, {leads[1]:.3g}" in found.text
    assert findings_of({"check": epicyclic.check("ren2021"), "": result})[-1].anchor != "meshes"


def test_without_load_or_variation_a_sentence_says_so() -> None:
    still = epicyclic.contact("ren2021", mesh="sun-planet", torque="0 N m")
    (found,) = findings_of({"": still})
    assert (found.tone, found.text) == ("", "No load presses the teeth.")
    (found,) = findings_of({"": epicyclic.stiffness("lin1999-n4")})
    assert found.text == "The mesh stiffness does not vary."
    idle = motion().copy()
    idle["mesh_force_peak"] = 1e-12 * idle["mesh_force_peak"] / idle["mesh_force_peak"].max()
    (found,) = findings_of({"": idle})
    assert found.text == "No load presses the teeth."


def test_one_speed_is_no_range() -> None:
    one = contact_sweep([[False] * 5, [False] * 5]).isel(speed=[2])
    (found,) = findings_of({"": one})
    assert found.text.startswith("No tooth loses contact at 100 % of the operating speed; ")


def test_a_mesh_alone_says_its_error_and_load() -> None:
    result = epicyclic.contact("ren2021", mesh="sun-planet", loads=(0.5, 1.0), samples=16, slices=8)
    (found,) = findings_of({"": result})
    at = result.isel(torque_factor=1)
    assert f"error {1e6 * float(at.transmission_error_peak_to_peak):.3g} µm peak to peak" in found.text
    assert f"largest load {float(at.largest_load_per_length.max()) / 1e3:.0f} N/mm" in found.text
    assert f"K_H beta {float(at.face_load_factor.max()):.2f}" in found.text
