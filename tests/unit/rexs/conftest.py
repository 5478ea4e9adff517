"""A small REXS file of our own making, as data that tests change and write as XML or JSON; and where real ones are."""

from __future__ import annotations

import copy
import json
import math
import os
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import pytest

Values = dict[str, tuple[Any, str]]
DATA = Path(os.environ.get("EPICYCLIC_DATA", Path(__file__).parents[4] / "shared" / "data")) / "rexs"


@dataclass
class Draft:
    """A REXS file: components (id -> type, name, attributes), relations (type, role -> id), load cases."""

    version: str = "1.6"
    components: dict[int, tuple[str, str, Values]] = field(default_factory=dict)
    relations: list[tuple[str, dict[str, int]]] = field(default_factory=list)
    load_cases: dict[int, dict[int, Values]] = field(default_factory=dict)

    def add(self, number: int, kind: str, name: str = "", **values: tuple[Any, str]) -> None:
        self.components[number] = (kind, name, dict(values))

    def relate(self, kind: str, **roles: int) -> None:
        self.relations.append((kind, roles))

    def values(self, number: int) -> Values:
        return self.components[number][2]

    def xml(self) -> str:
        parts = "".join(self._component(n, name, values) for n, (_, name, values) in self.components.items())
        relations = ""
        for i, (kind, roles) in enumerate(self.relations, start=1):
            refs = "".join(f'<ref id="{number}" role="{role}"/>' for role, number in roles.items())
            relations += f'<relation id="{i}" type="{kind}">{refs}</relation>'
        cases = ""
        for i, over in self.load_cases.items():
            inside = "".join(self._component(number, "", values) for number, values in over.items())
            cases += f'<load_case id="{i}">{inside}</load_case>'
        spectrum = f'<load_spectrum id="1">{cases}</load_spectrum>' if cases else ""
        return (
            f'<?xml version="1.0" encoding="UTF-8"?><model version="{self.version}" applicationId="test" '
            f'applicationVersion="1" date="2024-01-01T00:00:00+00:00"><relations>{relations}</relations>'
            f"<components>{parts}</components>{spectrum}</model>"
        )

    def _component(self, number: int, name: str, values: Values) -> str:
        head = f'<component id="{number}" type="{self.components[number][0]}" name={quoteattr(name)}>'
        return f"{head}{_xml_values(values)}</component>"

    def json(self) -> str:
        spectrum = [
            {
                "id": i,
                "components": [
                    {"id": n, "type": self.components[n][0], "attributes": _json_values(v)} for n, v in over.items()
                ],
            }
            for i, over in self.load_cases.items()
        ]
        model: dict[str, Any] = {
            "version": self.version,
            "applicationId": "test",
            "applicationVersion": "1",
            "date": "2024-01-01T00:00:00+00:00",
            "relations": [
                {"id": i, "type": kind, "refs": [{"id": n, "role": role} for role, n in roles.items()]}
                for i, (kind, roles) in enumerate(self.relations, start=1)
            ],
            "components": [
                {"id": n, "type": kind, "name": name, "attributes": _json_values(values)}
                for n, (kind, name, values) in self.components.items()
            ],
        }
        if spectrum:
            model["load_spectrum"] = {"id": 1, "load_cases": spectrum}
        return json.dumps({"model": model})


def _xml_values(values: Values) -> str:
    texts = []
    for name, (value, unit) in values.items():
        if isinstance(value, list):
            inner = "<array>" + "".join(f"<c>{_xml(v)}</c>" for v in value) + "</array>"
        else:
            inner = _xml(value)
        texts.append(f"<attribute id={quoteattr(name)} unit={quoteattr(unit)}>{inner}</attribute>")
    return "".join(texts)


def _xml(value: Any) -> str:
    return ("true" if value else "false") if isinstance(value, bool) else str(value)


def _json_values(values: Values) -> list[dict[str, Any]]:
    kinds = {bool: "boolean", int: "integer", float: "floating_point", str: "string"}
    return [
        {
            "id": name,
            "unit": unit,
            (f"{kinds[type(value[0])]}_array" if isinstance(value, list) else kinds[type(value)]): value,
        }
        for name, (value, unit) in values.items()
    ]


MM, DEG = "mm", "deg"
HELIX = 15.0
A = 4 * (24 + 30) / 2 / math.cos(math.radians(HELIX))  # reference centre distance [mm]


def at(u: float, v: float = 0.0, w: float = 0.0) -> Values:
    """Place and axes of a component that lies along the axis of the unit."""
    return {
        "reference_component_for_position": (1, "none"),
        "support_vector": ([u, v, w], MM),
        "u_axis_vector": ([1.0, 0.0, 0.0], MM),
        "w_axis_vector": ([0.0, 0.0, 1.0], MM),
    }


def small_unit() -> Draft:
    """A helical stage 24/30/84: right-handed sun without bearing, planets in elastic bearings, ring in a coupling.

    Planets stand at 0, 240, 120 deg about u, as the positions of programs do.
    """
    d = Draft()
    d.add(1, "gear_unit", "Small unit", **at(0.0))
    d.add(2, "gear_casing", "Casing")
    d.add(3, "planetary_stage", "Stage")
    d.add(4, "planet_carrier", "Carrier")
    d.add(
        90,
        "material",
        "Steel",
        density=(7.8, "kg / dm^3"),
        elastic_modulus=(2.1e5, "N / mm^2"),
        poisson_ratio=(0.3, "none"),
    )
    gear: Values = {"normal_module": (4.0, MM), "face_width": (50.0, MM)}
    d.add(10, "shaft", "Sun shaft", **at(0.0), rotational_speed=(1500.0, "1 / min"), defines_speed=(True, "none"))
    d.add(
        11,
        "cylindrical_gear",
        "Sun",
        **at(100.0),
        **gear,
        number_of_teeth=(24, "none"),
        helix_angle_reference_diameter=(HELIX, DEG),
    )
    d.add(
        12,
        "shaft_section",
        "",
        length=(150.0, MM),
        outer_diameter_begin=(40.0, MM),
        outer_diameter_end=(40.0, MM),
        u_coordinate_on_shaft=(25.0, MM),
    )
    d.add(13, "external_load", "Input", torque_around_u_axis=(800.0, "N m"), defines_torque=(True, "none"))
    d.add(20, "shaft", "Ring shaft", **at(75.0))
    d.add(
        21,
        "ring_gear",
        "Ring",
        **at(100.0),
        **gear,
        number_of_teeth=(-84, "none"),
        helix_angle_reference_diameter=(-HELIX, DEG),
    )
    d.add(
        22,
        "shaft_section",
        "",
        length=(50.0, MM),
        outer_diameter_begin=(420.0, MM),
        outer_diameter_end=(420.0, MM),
        inner_diameter_begin=(370.0, MM),
        inner_diameter_end=(370.0, MM),
    )
    d.add(
        23,
        "coupling",
        "Torque arms",
        **at(110.0),
        radial_stiffness=(1e9, "N / m"),
        axial_stiffness=(2e9, "N / m"),
        bending_stiffness=(5e9, "N mm / rad"),
        rotational_stiffness=(3e10, "N mm / rad"),
    )
    d.add(30, "shaft", "Carrier shaft", **at(-60.0), rotational_speed=(333.0, "1 / min"))
    d.add(
        31, "side_plate", "Plate", **at(50.0), length=(20.0, MM), outer_diameter=(300.0, MM), inner_diameter=(60.0, MM)
    )
    d.add(32, "external_load", "Output", transmits_torque=(True, "none"))
    for i, u in ((33, -50.0), (34, 40.0)):
        d.add(
            i,
            "concept_bearing",
            f"Carrier bearing {i}",
            **at(u),
            radial_stiffness=(6e8, "N / m"),
            axial_stiffness=(3e8 if i == 33 else 1e20, "N / m"),
            axial_force_absorption=("both_directions" if i == 33 else "no_direction", "none"),
            bending_stiffness=(0.0, "N mm / rad"),
        )
    for i, angle in enumerate((0, 240, 120)):
        v, w = -A * math.sin(math.radians(angle)), A * math.cos(math.radians(angle))
        n = 100 * (i + 1)
        d.add(n, "shaft", f"Planet shaft {i}", **at(75.0, v, w))
        d.add(
            n + 1,
            "cylindrical_gear",
            f"Planet {i}",
            **at(100.0, v, w),
            **gear,
            number_of_teeth=(30, "none"),
            helix_angle_reference_diameter=(-HELIX, DEG),
        )
        d.add(
            n + 2,
            "shaft_section",
            "",
            length=(50.0, MM),
            outer_diameter_begin=(65.0, MM),
            outer_diameter_end=(65.0, MM),
            inner_diameter_begin=(60.0, MM),
            inner_diameter_end=(60.0, MM),
        )
        d.add(n + 3, "shaft", f"Pin {i}", **at(60.0, v, w))
        d.add(
            n + 4,
            "concept_bearing",
            f"Planet bearing {i}",
            **at(100.0, v, w),
            radial_stiffness=(4e8 + 1e7 * i, "N / m"),
            axial_stiffness=(1e20, "N / m"),
            bending_stiffness=(1e9, "N mm / rad"),
        )
        for m, turned in ((n + 5, 0), (n + 6, 180)):
            d.add(
                m,
                "cylindrical_stage",
                "",
                center_distance=(A, MM),
                common_face_width=(50.0, MM),
                rotating_angle_around_neg_u_axis=(float(turned - angle), DEG),
            )
        for m in (n + 7, n + 8):
            d.add(
                m,
                "cylindrical_gear_flank",
                "",
                normal_pressure_angle=(20.0, DEG),
                addendum_modification_coefficient=(0.1, "none"),
            )
        d.relate("planet_shaft", planetary_stage=3, shaft=n)
        d.relate("planet_pin", planetary_stage=3, shaft=n + 3)
        d.relate("assembly", assembly=3, part=n + 5)
        d.relate("assembly", assembly=3, part=n + 6)
        d.relate("assembly", assembly=n, part=n + 1)
        d.relate("assembly", assembly=n, part=n + 2)
        d.relate("assembly", assembly=4, part=n + 3)
        d.relate("stage", stage=n + 5, gear_1=11, gear_2=n + 1)
        d.relate("stage", stage=n + 6, gear_1=n + 1, gear_2=21)
        d.relate("side", inner_part=n + 3, outer_part=n, assembly=n + 4)
        d.relate("flank", gear=n + 1, left=n + 7, right=n + 8)
    d.relate("assembly", assembly=1, part=3)
    d.relate("assembly", assembly=3, part=4)
    d.relate("central_shaft", planetary_stage=3, shaft=10)
    d.relate("central_shaft", planetary_stage=3, shaft=20)
    d.relate("planet_carrier_shaft", planetary_stage=3, shaft=30)
    d.relate("assembly", assembly=4, part=30)
    d.relate("assembly", assembly=4, part=31)
    d.relate("assembly", assembly=10, part=11)
    d.relate("assembly", assembly=10, part=12)
    d.relate("assembly", assembly=10, part=13)
    d.relate("assembly", assembly=20, part=21)
    d.relate("assembly", assembly=20, part=22)
    d.relate("assembly", assembly=30, part=32)
    d.relate("side", inner_part=20, outer_part=2, assembly=23)
    d.relate("side", inner_part=30, outer_part=2, assembly=33)
    d.relate("side", inner_part=30, outer_part=2, assembly=34)
    for origin in (10, 11, 20, 21, 30, 31, 100, 101, 200, 201, 300, 301):
        d.relate("reference", origin=origin, referenced=90)
    return d


_SMALL = small_unit()


@pytest.fixture
def draft() -> Draft:
    """The small unit, to be changed."""
    return copy.deepcopy(_SMALL)


@pytest.fixture
def real() -> Callable[[str], Path]:
    """Path of a real file by the end of its name; skips where the folder of data is not there."""

    def find(end: str) -> Path:
        found = sorted(DATA.glob(f"*{end}")) if DATA.is_dir() else []
        if not found:
            pytest.skip(f"no file *{end} in {DATA}: set EPICYCLIC_DATA")
        return found[0]

    return find
