"""Which verbs take tangents of tabulated meshes, and say so once a pair, and which ask the tables."""

from __future__ import annotations

import json
from typing import Any

import pytest

from epicyclic.verbs.record import Verb, verbs

PAIRS = tuple(f"stages.main.meshes.{pair}" for pair in ("sun-planet", "planet-ring"))
CONTACT = {f"{pair}.stiffness": "contact" for pair in PAIRS}
WORDS = "in place of the law of its gaps"

LINEAR = {
    "modes",
    "campbell",
    "steady",
    "sweep",
    "stability",
    "sharing",
    "load_factors",
    "detune",
    "sensitivity",
    "tolerance",
    "allocate",
    "track",
    "modulation",
    "matrices",
}
# verbs of the drawing, those that ask the laws, and relief, whose candidates have tables of their own
OTHER = {"check", "contact", "efficiency", "life", "output", "relief", "static", "stiffness", "transient"}
# options that turn a verb of the one kind into one of the other, beside its examples
FURTHER: dict[str, tuple[dict[str, Any], ...]] = {
    "sharing": ({"method": "static", "cycles": 2}, {"method": "superposition", "cycles": 2}),
    "steady": ({"method": "superposition"},),
    "transient": ({"cycles": 2, "contact": "linear"},),
    "modes": ({"relative_speed": 1.0, "damped": True},),
}


def takes_tangents(name: str, options: dict[str, Any]) -> bool:
    if options.get("contact_loss") or options.get("method") == "static":
        return False
    return name in LINEAR or options.get("contact") == "linear" or options.get("forces") == "steady"


CASES = [(verb, {**example}) for verb in verbs().values() for example in (*verb.examples, *FURTHER.get(verb.name, ()))]


def test_every_verb_is_of_one_kind() -> None:
    assert set(verbs()) == LINEAR | OTHER
    assert not LINEAR & OTHER


@pytest.mark.parametrize(("verb", "options"), CASES, ids=[f"{verb.name}-{list(options)}" for verb, options in CASES])
def test_linear_verbs_warn_once_a_pair_and_others_do_not(verb: Verb, options: dict[str, Any]) -> None:
    if verb.name == "relief":
        pytest.importorskip("pymoo")
    if verb.name == "tolerance":
        options["effects"] = "shares"  # every number of planets would compute tables of its own
    # and so would every train that output draws
    overrides = {**CONTACT, **options.pop("overrides", {}), **({"tolerance": None} if verb.name == "output" else {})}
    result = verb.run("industrial-stage", overrides=overrides, **options)
    said = [text.split(":")[0] for text in json.loads(result.attrs["warnings"]) if WORDS in text]
    assert said == (list(PAIRS) if takes_tangents(verb.name, options) else [])
