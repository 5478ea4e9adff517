"""Where the components are, and what they weigh.

Support vectors in nested reference frames become points and axes of the gear unit.  Masses and inertias of shafts,
plates and gear bodies follow from their sections, solids of revolution; they are derived here.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field

from ..errors import ModelError
from .file import Attribute, Component
from .view import View, number_of

Vector = tuple[float, float, float]
_MOST_FRAMES = 50  # references nested deeper than any gear unit: a loop


@dataclass(frozen=True, slots=True)
class PartFrame:
    """A place [m] and the axes u, v, w of a component, in the frame of the gear unit."""

    place: Vector
    u: Vector
    v: Vector
    w: Vector


_UNIT = PartFrame((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def along(a: Vector, b: Vector) -> float:
    """Scalar product."""
    return math.fsum(x * y for x, y in zip(a, b, strict=True))


def cross(a: Vector, b: Vector) -> Vector:
    """Vector product."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def minus(a: Vector, b: Vector) -> Vector:
    """Difference."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


@dataclass(slots=True)
class Places:
    """Frames of components, found when asked."""

    view: View
    _known: dict[int, PartFrame | None] = field(default_factory=dict)

    def frame(self, component: int) -> PartFrame | None:
        """Frame of a component; None where the file gives no place.

        Raises
        ------
        ModelError : no vector of three numbers, axes without direction, references in a circle.
        """
        return self._frame(component, 0)

    def on_shaft(self, component: int, shaft: int, coordinate: str) -> Vector | None:
        """Place of what sits on a shaft: its own, else its coordinate along the shaft."""
        own = self.frame(component)
        if own is not None:
            return own.place
        base, there = self.frame(shaft), self.view.number(component, coordinate, "length")
        if base is None or there is None:
            return None if base is None else base.place  # where along the shaft is not said
        (x, y, z), u, length = base.place, base.u, there.si
        return (x + u[0] * length, y + u[1] * length, z + u[2] * length)

    def _frame(self, component: int, depth: int) -> PartFrame | None:
        if component in self._known:
            return self._known[component]
        if depth > _MOST_FRAMES:
            raise ModelError("references of position in a circle", path=f"component {self.view.label(component)}")
        place = self._vector(component, "support_vector", "length")
        base: PartFrame | None = _UNIT
        reference = self.view.value(component, "reference_component_for_position")
        if isinstance(reference, (int, float)) and not isinstance(reference, bool) and int(reference) != component:
            if int(reference) in self.view.components:
                base = self._frame(int(reference), depth + 1) or _UNIT
        frame = None if place is None else self._in(base or _UNIT, place, component)
        self._known[component] = frame
        return frame

    def _in(self, base: PartFrame, place: Vector, component: int) -> PartFrame:
        """A frame given in another one."""
        u = self._axis(component, "u_axis_vector", (1.0, 0.0, 0.0))
        w = self._axis(component, "w_axis_vector", (0.0, 0.0, 1.0))
        absolute = _turned(base, place)
        origin = base.place
        axis, third = _turned(base, u), _turned(base, w)
        return PartFrame(
            (origin[0] + absolute[0], origin[1] + absolute[1], origin[2] + absolute[2]),
            axis,
            cross(third, axis),
            third,
        )

    def _vector(self, component: int, name: str, kind: str) -> Vector | None:
        """A vector attribute in SI; None where it is not given."""
        value = self.view.value(component, name)
        if value is None:
            return None
        where = f"component {self.view.label(component)}, {name}"
        if not isinstance(value, tuple) or len(value) != 3:
            shown = list(value) if isinstance(value, tuple) else value
            raise ModelError("not a vector", path=where, given=shown, allowed="an array of three numbers")
        owner = self.view.components[component]
        unit = owner.attributes[name].unit
        numbers = []
        for entry in value:
            read = number_of(Component(component, owner.type, "", {name: Attribute(name, entry, unit)}), name, kind)
            if read is None:
                raise ModelError("not a vector", path=where, given=list(value), allowed="an array of three numbers")
            numbers.append(read.si)
        return (numbers[0], numbers[1], numbers[2])

    def _axis(self, component: int, name: str, default: Vector) -> Vector:
        """A direction of length 1; its unit means nothing."""
        vector = self._vector(component, name, "length")
        if vector is None:
            return default
        size = math.sqrt(along(vector, vector))
        if not size > 1e-30:
            raise ModelError("a direction of length 0", path=f"component {self.view.label(component)}, {name}")
        return (vector[0] / size, vector[1] / size, vector[2] / size)


def _turned(base: PartFrame, vector: Vector) -> Vector:
    """A vector given along the axes of a frame."""
    u, v, w = base.u, base.v, base.w
    x, y, z = vector
    return (
        x * u[0] + y * v[0] + z * w[0],
        x * u[1] + y * v[1] + z * w[1],
        x * u[2] + y * v[2] + z * w[2],
    )


# Gauss points and weights of order 3 on [0, 1]: exact for polynomials of degree 5; those here have degree 4
_POINTS = tuple((0.5 + 0.5 * x, w / 18) for x, w in ((-math.sqrt(0.6), 5), (0.0, 8), (math.sqrt(0.6), 5)))


@dataclass(frozen=True, slots=True)
class SolidSection:
    """A hollow cone about an axis parallel to z.

    start, length : along z from the centre of the member [m].  outer, inner : diameters at both ends [m].
    density : [kg/m^3].  off_axis : distance of its axis from that of the member [m].
    """

    start: float
    length: float
    outer: tuple[float, float]
    inner: tuple[float, float]
    density: float
    off_axis: float = 0.0


@dataclass(frozen=True, slots=True)
class Inertia:
    """mass [kg]; about z and about a diameter through the centre of the member [kg m^2]."""

    mass: float
    polar: float
    tilt: float


def inertia_of(sections: Iterable[SolidSection]) -> Inertia:
    """Mass and inertias of sections together; those off the axis stand evenly around it."""
    mass = polar = tilt = 0.0
    for section in sections:
        for share, weight in _POINTS:
            z = section.start + share * section.length
            outer, inner = (_at(pair, share) / 2 for pair in (section.outer, section.inner))
            slab = section.density * section.length * weight * math.pi
            area, second = outer**2 - inner**2, (outer**4 - inner**4) / 2
            mass += slab * area
            polar += slab * (second + area * section.off_axis**2)
            # evenly around the axis, each stands on average for half of its distance squared
            tilt += slab * (second / 2 + area * (z**2 + section.off_axis**2 / 2))
    return Inertia(mass, polar, tilt)


def _at(pair: tuple[float, float], share: float) -> float:
    return pair[0] + (pair[1] - pair[0]) * share
