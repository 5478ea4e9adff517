"""Values that no REXS file should hold, and types that it may."""

from __future__ import annotations

from typing import Any

__all__ = ["JSON_NASTY", "NASTY", "TYPES"]

NASTY: tuple[Any, ...] = (
    *("nan", "inf", "-inf", "1e400", "-1e308", "1e-320", "0", "-1", "", " ", "true", "false", "NaN", "Infinity"),
    *("9" * 400, "9" * 5000, "1" * 19, "0x10", "1_000", "1,5", "1.6580", "+5", ".", "e5", "--1", "1e", "\u0661\u0662"),
    *("\x00", "\u2028", "\ud800", "\ufffe", "<", "&lol;", "]]>", "../../etc/passwd", "file:///etc/passwd", "=cmd()"),
    *(
        "custom_x",
        "mm",
        "none",
        "deg",
        "N / (mm mum)",
        "\u00b0",
        "furlong",
        "1e20",
        "5e-324",
        "a" * 10000,
        "%s%n",
        "{}",
    ),
)
JSON_NASTY: tuple[Any, ...] = (
    *(None, True, False, 0, -1, 1e308, -1e308, 10**30, 10**400, 2**63, 0.5, 1e-320, [], {}, [[]], [None], [{}]),
    *([1.0], [1.0, 2.0], [0.0] * 4, [[1.0], [1.0, 2.0]], [0.0, 0.0, 0.0], ["a", 1, None], {"code": "float64"}),
    *({"code": "float64", "value": "AAAA"}, {"code": "int32", "value": "####"}, {"code": "int32", "value": "A" * 9999}),
    {"code": "float64", "value": "AAAAAAAA8D8=", "rows": 10**9, "columns": 10**9},
)
TYPES = (
    *("shaft", "planetary_stage", "cylindrical_gear", "ring_gear", "planet_carrier", "gear_casing", "coupling"),
    *("concept_bearing", "external_load", "additional_mass", "material", "side_plate", "cylindrical_stage", "x", ""),
    *("assembly", "reference", "stage", "planet_shaft", "planet_pin", "central_shaft", "planet_carrier_shaft", "side"),
    *("flank", "ordered_assembly", "ordered_reference", "stage_gear_data", "switchable_coupling", "shaft_section"),
)
