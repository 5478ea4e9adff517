"""Values that a writer has lost: arrays and texts that stand as `false`, as some programs have written them in JSON."""

from __future__ import annotations

import re
from collections import Counter

from ..errors import ModelError
from .structure import RexsFile

__all__ = ["check_damage", "false_texts"]

_ARRAYS = ("support_vector", "u_axis_vector", "w_axis_vector", "is_engaged")
# attributes whose value is a text by the standard
_TEXTS = re.compile(
    r"^(?:name|kind|.*_designation|.*_name|determination_of_.*|type_of_.*|shape_of_.*|flag_designation_.*"
    r"|axial_force_absorption|datum_face_orientation|helix_evaluation_reference|.*tolerance_series.*"
    r"|.*_type_.*|.*_category_.*|.*_method_.*|lubrication_type.*|loaded_tooth_flank|manufacturer)$"
)


def check_damage(file: RexsFile) -> None:
    """Refuse a file in which places or the state of couplings stand as false.

    Raises
    ------
    ModelError : names the attributes that are lost, and how often.
    """
    lost: Counter[str] = Counter()
    first: dict[str, int] = {}
    for component in file.components:
        for name in _ARRAYS:
            attribute = component.attributes.get(name)
            single = attribute is not None and isinstance(attribute.value, bool)
            # a single truth value of a coupling is clear in XML, which has no types; in JSON the array is lost
            if single and (name != "is_engaged" or file.encoding == "json"):
                lost[name] += 1
                first.setdefault(name, component.id)
    if lost:
        parts = ", ".join(f"{name} ({count} times, first in component {first[name]})" for name, count in lost.items())
        texts = Counter(name for _, name in false_texts(file))
        also = f"; texts lost too: {', '.join(texts)}" if texts else ""
        problem = f"damaged: true or false stands where arrays belong, they are missing: {parts}{also}"
        raise ModelError(problem, path="components", allowed="the file written again, in XML or by a newer program")


def false_texts(file: RexsFile) -> list[tuple[int, str]]:
    """Attributes (component, name) that stand as false where a text belongs."""
    return [
        (component.id, attribute.id)
        for component in file.components
        for attribute in component.attributes.values()
        if attribute.value is False and _TEXTS.fullmatch(attribute.id)
    ]
