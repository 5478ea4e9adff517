"""Ripple in the model file: what it may say, what is refused, cases, files, overrides and the way back to TOML."""

from __future__ import annotations

import time
import tomllib
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from epicyclic import ModelError, modes, steady, sweep, transient
from epicyclic.document.document import read
from epicyclic.document.writer import model_text
from epicyclic.system.assembly import assemble
from epicyclic.train.resolution import load

EXAMPLE = Path(__file__).parents[3] / "examples" / "models" / "engine-planetary.toml"


def ripple(*parts: dict[str, Any], member: str = "engine", **more: Any) -> dict[str, Any]:
    """Overrides of the example that state its ripple anew."""
    return {"operation.ripple": None, f"operation.ripple.{member}": list(parts), **more}


def torque(**more: Any) -> dict[str, Any]:
    """A component of a torque ripple."""
    return {"order": 2, "torque": "5 N m", **more}


def frequencies(overrides: dict[str, Any]) -> list[Fraction]:
    """Frequencies of the torque ripple of the example."""
    return [line.frequency for line in assemble(load(EXAMPLE, overrides)).lines if line.ripple.any()]


@pytest.mark.parametrize(
    ("parts", "path", "words"),
    [
        ([torque(angle="1 deg")], "engine.1", "torque and angle together"),
        ([torque(order=-2)], "engine.1.order", "out of range"),
        ([torque(order=0)], "engine.1.order", "out of range"),
        ([torque(order="1/0")], "engine.1.order", "not an order"),
        ([torque(order="two")], "engine.1.order", "not an order"),
        ([torque(order="0." + "0" * 60 + "1")], "engine.1.order", "not an order"),
        ([torque(order=float("nan"))], "engine", "not a number"),
        ([{"order": 2, "phase": "20 deg"}], "engine.1", "without an amplitude"),
        ([{"torque": "5 N m"}], "engine.1", "without an order"),
        ([torque(frequency="5 Hz")], "engine.1", "order and frequency together"),
        ([torque(torque="-5 N m")], "engine.1.torque", "out of range"),
        ([torque(torque="5 m")], "engine.1.torque", "unit"),
        ([torque(of="main.rong")], "engine.1.of", "did you mean"),
        ([torque(of="main.ring")], "engine.1.order", "stands still"),
        ([{"frequency": "5 Hz", "torque": "5 N m", "of": "machine"}], "engine.1.of", "beside frequency"),
        ([torque(), {"order": 4, "angle": "1 deg"}], "engine.2", "with a torque ripple"),
        ([{"angles": "[0, 90, 180, 270] deg"}], "engine.1", "without an amplitude"),
        ([{"angles": "[0, 90, 180, 270] deg", "torques": "[1, 2] N m"}], "engine.1.torques", "2 torques"),
        ([{"angles": "[0, 90, 180] deg", "torques": "[1, 2, 3] N m"}], "engine.1.angles", "whole turns"),
        ([{"angles": "[0, 100, 180, 270] deg", "torques": "[1, 2, 3, 2] N m"}], "engine.1.angles", "whole turns"),
        ([{"angles": "[0, 120, 240, 360] deg", "torques": "[1, 2, 3, 4] N m"}], "engine.1.torques", "return"),
        ([{"file": "none.csv"}], "engine.1.file", "cannot be read"),
    ],
)
def test_what_is_wrong_is_told_by_its_path(parts: list[dict[str, Any]], path: str, words: str) -> None:
    with pytest.raises(ModelError, match=words) as caught:
        load(EXAMPLE, ripple(*parts))
    assert caught.value.path.startswith(f"operation.ripple.{path}")


@pytest.mark.parametrize(
    ("member", "words"), [("main.ring", "ground"), ("main.planet", "planet gear"), ("engin", "no such member")]
)
def test_a_shaft_that_takes_no_ripple_is_refused(member: str, words: str) -> None:
    with pytest.raises(ModelError, match=words):
        load(EXAMPLE, ripple(torque(), member=member))


def test_orders_are_exact_and_follow_the_shaft_they_count() -> None:
    """25 turns a second of the engine; the machine turns 26 times in 102 of them."""
    assert frequencies(ripple(torque(order="1/2"), torque(order=1.5))) == [Fraction(25, 2), Fraction(75, 2)]
    assert frequencies(ripple(torque(order=" 1 / 3"))) == [Fraction(25, 3)]
    assert frequencies(ripple(torque(order=1, of="machine"))) == [Fraction(25 * 26, 102)]
    assert frequencies(ripple({"frequency": "33.3 Hz", "torque": "1 N m"})) == [Fraction(333, 10)]


def test_an_order_of_many_digits_is_refused_in_time(slowness: float) -> None:
    """A number of ten million digits is not made."""
    load(EXAMPLE)
    start = time.process_time()
    with pytest.raises(ModelError, match="not an order"):
        load(EXAMPLE, ripple(torque(order="1e10000000")))
    assert time.process_time() - start < 0.2 * slowness


def test_a_member_may_be_named_file() -> None:
    """Its torque and speed are numbers, and name no file of a ripple."""
    gears = {"file": {"kind": "gear", "teeth": 20}, "wheel": {"kind": "gear", "teeth": 40}}
    stage = {"module": "3 mm", "face_width": "20 mm", **gears, "meshes": {"file-wheel": {}}}
    loads = {"speed": {"file": "12 rev/s"}, "torque": {"file": "10 N m"}}
    part = {"order": 2, "torque": "1 N m"}
    model = {"format": 2, "title": "a pair", "stages": {"s": stage}, "operation": {**loads, "ripple": {"file": [part]}}}
    assert [line.frequency for line in load(model).ripples] == [24]
    assert load(model, {"cases.low.torque.file": "5 N m", "case": "low"}).ripples == load(model).ripples


def test_a_file_is_its_table(tmp_path: Path) -> None:
    """Angles and torques of a CSV file count as those of the lists, a last point that closes the turn left out."""
    rows = [(angle, 250 + 10 * np.cos(np.radians(3 * angle))) for angle in range(0, 361, 30)]
    tmp_path.joinpath("turn.csv").write_text(
        "angle [deg], torque [N m]\n" + "\n".join(f"{angle}, {float(value)!r}" for angle, value in rows)
    )
    model = tmp_path / "model.toml"
    head, _, tail = EXAMPLE.read_text().partition("[[operation.ripple.engine]]")
    cases = "[cases.light]" + tail.partition("[cases.light]")[2]
    model.write_text(f'{head}[operation.ripple]\nengine = [{{ file = "turn.csv" }}]\n\n{cases}')
    (found,) = load(model, {"case": "loaded"}).ripples
    assert found.frequency == 75
    assert found.follows
    assert found.amplitude == pytest.approx(10, abs=1e-9)
    tmp_path.joinpath("turn.csv").write_text("angle [deg], force [N]\n0, 1\n")
    with pytest.raises(ModelError, match="line 1"):
        load(model)


def test_the_mean_of_a_table_is_told_where_it_is_another() -> None:
    table = {"angles": "[0, 90, 180, 270] deg", "torques": "[260, 240, 260, 240] N m"}
    assert not [text for text in load(EXAMPLE, ripple(table, case="loaded")).warnings if "[ripple-mean]" in text]
    assert [text for text in load(EXAMPLE, ripple(table)).warnings if "[ripple-mean]" in text]


def test_a_case_has_a_ripple_of_its_own() -> None:
    own = {"cases.light.ripple.engine": [torque(order=3)]}
    assert frequencies(own) == [75]
    assert frequencies({**own, "case": "loaded"}) == [50, 100, 150]
    with pytest.raises(ModelError, match="stands still") as caught:
        load(EXAMPLE, {"cases.light.ripple.engine": [torque(of="main.ring")]})
    assert caught.value.path.startswith("cases.light.ripple.engine.1")


def test_a_machine_without_inertia_is_told() -> None:
    """The gear alone is far too light; a body behind a coupling, or an inertia of the member, is enough."""
    codes = {
        member: [text for text in load(EXAMPLE, ripple(torque(), member=member)).warnings if "-inertia]" in text]
        for member in ("main.sun", "engine")
    }
    assert not codes["engine"]
    assert not codes["main.sun"]  # the engine stands behind its coupling
    alone = ripple(torque(), member="main.sun", **{"bodies.engine.inertia": "0 kg m^2"})
    assert [text for text in load(EXAMPLE, alone).warnings if "[ripple-without-inertia]" in text]


def test_without_speeds_and_locked_it_is_left_out() -> None:
    still = load(EXAMPLE, {"operation.speed": None})
    held = {"operation.held": ["main.ring", "main.carrier"]}
    locked = load(EXAMPLE, {"operation.speed": None, "case": None, "operation.torque.machine": None, **held})
    for train, why in ((still, "no speed is given"), (locked, "the train is locked")):
        assert not train.ripples
        assert [text for text in train.warnings if "[ripple-without-speed]" in text and why in text]


def test_a_frequency_holds_at_the_operating_speed_alone() -> None:
    """Verbs at other speeds refuse it by its path, where the speed is that of operation it counts."""
    fixed = ripple({"frequency": "40 Hz", "torque": "5 N m"}, case="loaded")
    assert 40 in [round(value) for value in steady(EXAMPLE, overrides=fixed).line_frequency.values]
    calls: tuple[Callable[[], Any], ...] = (
        lambda: steady(EXAMPLE, overrides=fixed, relative_speed=0.9),
        lambda: steady(EXAMPLE, overrides=fixed, relative_speed=0.9, contact_loss=True),
        lambda: sweep(EXAMPLE, overrides=fixed, relative_speed=[0.9, 1.0]),
        lambda: sweep(EXAMPLE, overrides=fixed, relative_speed=[0.9, 1.0], contact_loss=True),
        lambda: transient(EXAMPLE, overrides=fixed, start="300 Hz", cycles=5),
    )
    for call in calls:
        with pytest.raises(ModelError, match="does not follow the speed") as caught:
            call()
        assert caught.value.path == "operation.ripple.engine.1.frequency"
    assert np.isfinite(modes(EXAMPLE, overrides=fixed).resonance_force_ratio.values).any()


def test_overrides_reach_a_component_and_a_list_takes_the_place_of_all() -> None:
    changed = load(EXAMPLE, {"operation.ripple.engine.2.torque": "7 N m", "operation.ripple.engine.3": None})
    assert [abs(part.amplitude) for part in changed.ripples] == pytest.approx([160, 7])
    assert len(load(EXAMPLE, {"operation.ripple.engine": [torque()]}).ripples) == 1


def test_it_goes_to_toml_and_back() -> None:
    """The document written is read as the same train."""
    written = model_text(read(EXAMPLE).data)
    assert load(tomllib.loads(written)).ripples == load(EXAMPLE).ripples


def test_a_split_member_shares_its_torque() -> None:
    split = {"stages.main.sun.split": True, "stages.main.sun.neck": {"diameter": "20 mm", "length": "10 mm"}}
    split |= {"stages.main.helix_angle": "20 deg", "stages.main.herringbone": True, "stages.main.gap": "5 mm"}
    split |= {"couplings.damper.between": ["engine", "main.sun.left"]}
    parts = load(EXAMPLE, ripple(torque(), member="main.sun", **split)).ripples
    assert [part.amplitude for part in parts] == pytest.approx([2.5, 2.5])


def test_imposed_motions_at_both_ends_are_refused() -> None:
    """Each takes whatever torque comes: none passes through the train."""
    both = {f"operation.ripple.{end}": [{"order": 1, "angle": "0.5 deg"}] for end in ("engine", "machine")}
    with pytest.raises(ModelError, match=r"ripple.machine: the motion of engine and machine is imposed"):
        load(EXAMPLE, {"operation.ripple": None, "case": "loaded", **both})


def test_transmission_errors_have_their_common_period_at_any_speed() -> None:
    """Sidebands that are nothing do not make it too long."""
    for speed in (1.0, 0.5):
        result = steady(str(EXAMPLE), overrides={"case": "loaded"}, relative_speed=speed)
        assert result["period"].values.tolist()[-1] == "common period"


def test_just_below_the_torque_that_holds_teeth_together_they_part_too() -> None:
    """No result of contact loss pulls on teeth: where a line superposed would, the motion is followed in time."""
    pytest.importorskip("numba")
    shares = []
    for torque in (28.0, 33.0):
        changes = {"case": "loaded", "cases.loaded.torque.engine": f"{torque} N m"}
        result = steady(str(EXAMPLE), overrides=changes, contact_loss=True)
        least = float(steady(str(EXAMPLE), overrides=changes).mesh_force_minimum.min())
        shares.append((float(result.open_share.max()), least, float(result.mesh_force_minimum.min())))
    (apart, pulled, touching), (closed, pressed, _) = shares
    assert pulled < 0 < pressed  # linear contact tells where
    assert apart > 0.05
    assert touching == 0
    assert closed == 0
