"""Coupled members are coaxial: stages on fixed axes and free bodies are moved beside each other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ..model.schema import ModelFile
from ..train.bodies import Body

__all__ = ["coaxial"]


def coaxial(bodies: Sequence[Body], model: ModelFile) -> list[Body]:
    """Move stages on fixed axes, and bodies, so that what a coupling joins has one axis.

    A stage with a carrier stays around the origin; so does the first stage. What a loop of couplings leaves apart
    stays apart.
    """
    group = {body.name: body.frame if "." in body.member else body.name for body in bodies}
    fixed = [name for name, stage in model.stages.items() if any(m.kind == "carrier" for m in stage.members.values())]
    offset: dict[str, complex] = dict.fromkeys([*fixed, next(iter(model.stages))], 0j)
    ends = [(_end(table.between[0], bodies), _end(table.between[1], bodies)) for table in model.couplings.values()]
    joints = [(a, b) for a, b in ends if a is not None and b is not None]
    joints += [(b, a) for a, b in joints]
    for _ in joints:
        for a, b in joints:
            if group[a.name] in offset and group[b.name] not in offset:
                offset[group[b.name]] = offset[group[a.name]] + complex(*a.centre) - complex(*b.centre)
    return [_moved(body, offset.get(group[body.name], 0j)) for body in bodies]


def _end(reference: str, bodies: Sequence[Body]) -> Body | None:
    member = ".".join(reference.split(".")[:2])
    return next((body for body in bodies if body.member == member), None)


def _moved(body: Body, by: complex) -> Body:
    return body if by == 0 else replace(body, centre=(body.centre[0] + by.real, body.centre[1] + by.imag))
