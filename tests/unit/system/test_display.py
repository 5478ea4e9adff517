"""Short reprs of a System and its parts, and the coupling pattern that notebooks show."""

from __future__ import annotations

from xml.etree import ElementTree

import pytest

import epicyclic
from epicyclic.system.system import System

SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture(params=("ren2021", "xu2020", "encased-differential", "lin1999-n3"))
def system(request: pytest.FixtureRequest) -> System:
    return epicyclic.assemble(epicyclic.load(request.param))


def test_reprs_are_one_short_line(system: System) -> None:
    assert len(repr(system)) < 250
    parts = (system.dofs, system.meshes, system.links, system.far_flanks)
    for part in (*parts, *system.lines, *system.groups, *system.symmetries):
        assert len(repr(part)) < 150
        assert "\n" not in repr(part)


def test_repr_holds_the_key_numbers() -> None:
    text = repr(epicyclic.assemble(epicyclic.load("xu2020")))
    assert "56 dofs, 16 mesh rows, 78 link rows, 0 laws, 27.392 Hz, 1 lines, damping modal 0.03" in text


def test_laws_are_counted() -> None:
    overrides = {
        "stages.main.sun.support.clearance": "20 um",
        "stages.main.meshes.sun-planet.stiffness": "contact",
    }
    system = epicyclic.assemble(epicyclic.load("ren2021", overrides=overrides))
    assert repr(system.groups[0]).startswith("LawGroup('main/sun/support', play, 2 rows")
    assert repr(system.meshes.laws[0].law).startswith("TabulatedLaw(3 rows, 50 phases x 21 loads")
    cells = [cell.text for cell in ElementTree.fromstring(system._repr_html_()).iter("td")]
    assert cells[cells.index("links with a law") + 1] == "1 play"
    assert cells[cells.index("meshes with a law") + 1] == "6 rows"


def test_html_is_well_formed_and_complete(system: System) -> None:
    text = system._repr_html_()
    assert len(text) < 60_000
    root = ElementTree.fromstring(text)
    cells = [cell.text or "" for cell in root.iter("td")]
    assert not any("nan" in cell for cell in cells)
    assert cells[cells.index("degrees of freedom") + 1].startswith(f"{len(system.dofs.names)} of ")
    assert cells[cells.index("linear link rows") + 1] == str(len(system.links.name))
    for tone in system.tones:
        assert f"{float(tone):.5g}" in cells[cells.index("mesh frequencies [Hz]") + 1]


def test_pattern_couples_what_meshes() -> None:
    system = epicyclic.assemble(epicyclic.load("lin1999-n3"))
    titles = [title.text for title in ElementTree.fromstring(system._repr_html_()).iter(f"{SVG}title")]
    assert titles.count("main/sun, main/planet/1: mesh") == 2
    assert "main/sun, main/ring: mesh" not in titles
    assert "main/carrier, main/planet/2: link" in titles
