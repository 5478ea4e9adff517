"""The wizard of a new train: what is typed becomes a model, and nothing typed is lost."""

from __future__ import annotations

import pytest

pytest.importorskip("nicegui")

from nicegui import ui
from nicegui.testing.user import User
from tests.unit.cockpit.dialog_session import FakeSession
from tests.unit.cockpit.visit import put, seen, until, visit

from epicyclic.cockpit.page.wizard import BESIDE, drivers_of, needed, new_button, preview_of, sets_in
from epicyclic.cockpit.state.state import request_of, tables_of
from epicyclic.errors import ModelError
from epicyclic.train.new_train import new_train
from epicyclic.train.resolution import load

OWN = {
    "teeth": "21/39/99",
    "module": "10",
    "helix_angle": "7.5",
    "face_width": "200 mm",
    "power": "750",
    "speed": "1000",
}


def test_the_fields_give_the_train_of_the_command() -> None:
    told = preview_of({"kind": "planetary", "by": "teeth", "planets": "3", "load": "power", "held": "ring", **OWN})
    same = new_train(
        kind="planetary",
        teeth="21/39/99",
        planets=3,
        module="10 mm",
        helix_angle="7.5 deg",
        face_width="200 mm",
        power="750 kW",
        speed="1000 rpm",
        held="ring",
    )
    assert tables_of(told.text) == same.document
    assert "Ratio 5.7143" in told.facts[0]
    assert "centre distance 302.589 mm" in told.facts[0]


def test_a_decimal_comma_is_a_point_and_thousands_are_refused() -> None:
    fields = {"by": "teeth", "planets": "3", **OWN}
    for module in ("7,5", "7,5 mm"):
        assert tables_of(preview_of({**fields, "module": module}).text)["stages"]["main"]["module"] == "7.5 mm"
    for field, text in (("speed", "1,000"), ("speed", "1,000 rpm"), ("speed", "1 000 rpm"), ("face_width", "1,200 mm")):
        with pytest.raises(ModelError, match="within the number") as error:
            preview_of({**fields, field: text})
        assert error.value.path == field
    with pytest.raises(ModelError) as error:
        preview_of({**fields, "teeth": "21,39,99"})
    assert error.value.given == "21,39,99"
    for title in ("3,5 MW", "2026"):
        assert preview_of({**fields, "title": title}).title == title


def test_what_a_rule_chose_gives_way_to_what_is_said() -> None:
    said = {"damping.modal": "0.05", "stages.main.sun.support.radial": "0", "stages.main.carrier.mass": "480"}
    document = tables_of(preview_of({"by": "teeth", "planets": "3", **OWN, **said}).text)
    assert document["damping"]["modal"] == 0.05
    assert document["stages"]["main"]["sun"]["support"]["radial"] == "0"
    assert document["stages"]["main"]["carrier"]["mass"] == "480 kg"
    assert not set(said) & set(document["assumed"])
    assert "stages.main.carrier.inertia" in document["assumed"]


@pytest.mark.parametrize(
    ("fields", "path"),
    [
        ({"teeth": "21/39/98"}, "teeth"),
        ({"planets": "7"}, "planets"),
        ({"by": "ratio", "ratio": "20"}, "ratio"),
        ({"by": "ratio", "ratio": "six"}, "ratio"),
        ({"module": "10 kg"}, "module"),
        ({"power": "-750"}, "power"),
        ({"speed": ""}, "speed"),
        ({"kind": "odd", "driver": "sun"}, "kind"),
        ({"damping.modal": "5"}, "damping.modal"),
        ({"stages.main.carrier.mass": "heavy"}, "stages.main.carrier.mass"),
        ({"kind": "star", "held": "ring", "driver": "carrier", "teeth": "9/9/27"}, "teeth"),
    ],
)
def test_a_wrong_value_is_named_by_its_field(fields: dict[str, str], path: str) -> None:
    with pytest.raises(ModelError) as error:
        preview_of({"kind": "planetary", "by": "teeth", "planets": "3", "load": "power", **OWN, **fields})
    assert error.value.path == path
    assert error.value.allowed


@pytest.mark.parametrize(
    "fields",
    [
        {"kind": "star", "teeth": "21/39/99", "torque": "7", "load": "torque", "speed": "1000"},
        {"kind": "planetary", "by": "ratio", "ratio": "4.5", "planets": "4", "power": "1 MW", "speed": "1500"},
        {"kind": "planetary", "held": "sun", "teeth": "21/39/99", "power": "100", "speed": "500"},
        {
            "kind": "differential",
            "teeth": "21/39/99",
            "speed.sun": "1000",
            "speed.carrier": "100",
            "load": "torque",
            "load_member": "sun",
            "torque": "500",
        },
    ],
)
def test_every_kind_ends_in_a_model_that_loads(fields: dict[str, str]) -> None:
    assert not needed(fields)
    found = preview_of({"planets": "3", **fields})
    assert load(tables_of(found.text)).meshes
    assert set(BESIDE) <= set(found.by_rule)


def test_members_that_may_drive() -> None:
    assert drivers_of("planetary", "ring") == drivers_of("planetary", "") == ("sun", "carrier")
    assert drivers_of("differential", "") == drivers_of("compound", "ring") == ()  # stated by member


def test_sets_of_teeth_are_found_in_words() -> None:
    assert sets_in("Teeth 21/39/99 (5.714); as well: 20/40/100, 21/39/99.") == ("21/39/99", "20/40/100")


def test_the_window_makes_a_model_and_keeps_what_was_typed() -> None:
    async def talk(user: User, session: FakeSession) -> None:
        user.find("New").click()
        await seen(user, "Still needed: teeth, power, speed")
        put(user, "new-teeth", "21/39/98")
        for name, value in OWN.items():
            if name != "teeth":
                put(user, f"new-{name}", value)
        await seen(user, "21/39/99")  # proposed instead
        (teeth,) = (one for one in user.find(marker="new-teeth").elements if isinstance(one, ui.input))
        teeth.error = None
        user.find("Create").click()
        await until(lambda: "make a ring of 99" in str(teeth.error))
        assert session.now.name == "ren2021"  # a wrong value opens nothing, and stays
        assert teeth.value == "21/39/98"
        put(user, "new-teeth", "21/39/99")
        await seen(user, "Ready: a model that runs")
        await user.should_see("no strength rating")
        user.find("Create").click()
        await until(lambda: session.history.undo_label.startswith("open Planetary-set-21-39-99"))
        user.find("New").click()
        (power,) = (one for one in user.find(marker="new-power").elements if isinstance(one, ui.input))
        assert power.value == "750"

    session = visit(new_button, talk)
    source, overrides = request_of(session.now)
    assert len(load(source, overrides=overrides).meshes) == 6
    assert "wizard" in session.now.base
    assert session.unsaved
