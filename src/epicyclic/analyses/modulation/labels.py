"""Labels, families and causes of the lines at the sensor.

A line stands at  sum_j l_j f_j + f_shaft + k f_carrier: mesh orders, a shaft line in the axes of the stage, and the
shift by planets that pass the sensor.  With even planets that are alike only sidebands with l z + k a multiple of N
survive, z the teeth of the ring, N the planets: asymmetric about the mesh orders, which vanish themselves, where z / N
is not whole [mcfadden1985].  Uneven or unlike planets bring the others [inalpolat2009].
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from ...questions.response.excitation import LineExcitation, Shaft
from ...system.system import System
from .sensor import SensorPosition, mesh_stages
from .spectrum import LineSource, StageSpectrum

__all__ = ["LineLabels", "Origin", "is_fault_free"]

MESH, PASSING, MEAN = "mesh", "planets passing", "mean load passing"
UNEVEN, UNLIKE = "uneven planets", "unlike planets"
_MESHING = "tooth meshing"
_FAULT_FREE = "fault-free: planets passing"
_UNEVEN_CAUSE = "fault-free asymmetry: planet angles, mesh phases"


@dataclass(frozen=True, slots=True, kw_only=True)
class Origin:
    """Frequency = sum_j mesh_j f_j + sign f_shaft + carrier |f_carrier|.  shaft : its index, -1 without."""

    mesh: tuple[int, ...]
    shaft: int
    sign: int
    carrier: int


@dataclass(frozen=True, slots=True, kw_only=True)
class LineLabels:
    """Labels of the lines of one System at one sensor position."""

    system: System
    lines: LineExcitation
    position: SensorPosition

    @property
    def own(self) -> int:
        """Axis of the tone of the stage."""
        return int(self.lines.axis[self.position.meshes[0]])

    def label(self, origin: Origin) -> str:
        """Label of a line: ``2 x mesh + sun run-out - 3 x carrier``."""
        terms = [(count, f"{abs(count)} x {self._mesh(j)}") for j, count in enumerate(origin.mesh)]
        if origin.shaft >= 0:
            terms.append((origin.sign, self.shaft_name(origin.shaft)))
        terms.append((origin.carrier, f"{abs(origin.carrier)} x carrier"))
        text = ""
        for count, name in sorted(terms, key=lambda term: term[0] < 0):
            if count:
                text += (" + " if count > 0 else " - ") + name
        return text.removeprefix(" + ").strip()

    def family(self, origin: Origin, *, faulty: bool) -> str:
        """Family of a line, the one word for its cause.  faulty : the line is hardly there without deviations."""
        if origin.shaft >= 0:
            return self.shaft_name(origin.shaft)
        others = [self._mesh(j) for j, count in enumerate(origin.mesh) if count and j != self.own]
        if others:
            return f"{others[0]} of another stage"
        order = origin.mesh[self.own]
        if self._passes(origin):
            return MEAN if order == 0 else PASSING if origin.carrier else MESH
        return UNLIKE if faulty or self.position.even else UNEVEN

    def causes(self, origins: Sequence[Origin], *, faulty: bool) -> str:
        """Causes of a line with paths in the file, the largest part first.  faulty : as of `family`."""
        found: dict[str, None] = {}
        for one in origins:
            shaft = self.lines.shaft[one.shaft].causes if one.shaft >= 0 else None
            found.update(dict.fromkeys(self._causes(one, faulty=faulty) if shaft is None else shaft))
        return "; ".join(found)

    def origin(self, spectrum: StageSpectrum, part: LineSource) -> Origin:
        """Origin of a source of a line."""
        sign, turn = -1 if part.negative else 1, 0 if spectrum.carrier == 0 else 1 if spectrum.carrier > 0 else -1
        return Origin(
            mesh=tuple(sign * int(count) for count in spectrum.point[part.row]),
            shaft=int(spectrum.shaft[part.row]),
            sign=sign,
            carrier=sign * turn * part.order,
        )

    def shaft_name(self, number: int) -> str:
        """Name of a shaft line from paths and exact orders: ``sun run-out``, ``3 x sun pitch``."""
        shaft = self.lines.shaft[number]
        return " & ".join(dict.fromkeys(self._shaft_word(shaft, path) for path in shaft.causes)) or "shaft"

    def _causes(self, origin: Origin, *, faulty: bool) -> list[str]:
        """Causes of one origin at mesh orders."""
        family, own = self.family(origin, faulty=faulty), self._at_order(origin.mesh)
        standing = self._at_order((0,) * len(origin.mesh))
        faults = [path for path in standing if path.startswith("deviations.")] if faulty else []
        if family == UNLIKE:
            return [*faults, *own] or ["planets that differ"]
        first = _UNEVEN_CAUSE if family == UNEVEN else _FAULT_FREE if origin.carrier else _MESHING
        return [first, *own, *faults]

    def _at_order(self, mesh: tuple[int, ...]) -> list[str]:
        """Paths of the lines at a mesh order, or at 0, of either sign."""
        mirrored = tuple(-count for count in mesh)
        return [cause for point, line in self.lines.mesh if point in (mesh, mirrored) for cause in line.causes]

    def _passes(self, origin: Origin) -> bool:
        """Whether a line of mesh orders survives with even planets that are alike [mcfadden1985]."""
        count, teeth = len(self.position.spacing), self.position.teeth
        if self.position.turn == 0:
            return True
        if teeth is None:
            return origin.carrier % count == 0
        forwards = 1 if self.position.turn > 0 else -1
        # planet n meshes z_ring psi_n / 2 pi cycles earlier, the other way round where the ring's teeth come forwards
        return (-origin.mesh[self.own] * teeth + forwards * origin.carrier) % count == 0

    def _mesh(self, tone: int) -> str:
        """Name of a tone."""
        if len(self.lines.tones) == 1:
            return "mesh"
        return f"{self.lines.stages(self.system)[tone]} mesh"

    def _shaft_word(self, shaft: Shaft, path: str) -> str:
        """``deviations.main.sun.run_out`` -> ``sun run-out``, with the order where it is not the first."""
        stages = tuple(dict.fromkeys(mesh_stages(self.system)))
        parts = path.split(".")[1:]
        member = ".".join(parts[:2]) if parts[:1] and parts[0] in stages else parts[0] if parts else path
        if len(stages) == 1:
            parts = parts[1:] if parts[:1] == [stages[0]] else parts
        words = " ".join(parts).replace("run_out", "run-out").replace("_", " ") or path
        order = self._order(shaft.frequency, member)
        return words if order in (None, 1) else f"{order} x {words}"

    def _order(self, frequency: Fraction, member: str) -> int | None:
        """Turns of a member in the axes of the stage in one period, None where they are no whole number."""
        name = member.replace(".", "/")
        for body, turns in zip(self.system.dofs.bodies, self.system.body_turns, strict=True):
            if body == name or body.startswith(f"{name}/"):
                relative = turns - self.system.stage_turns.get(name.split("/")[0], Fraction(0))
                order = abs(frequency / relative) if relative else Fraction(0)
                return int(order) if order.denominator == 1 and order else None
        return None


def is_fault_free(causes: Sequence[str]) -> bool:
    """Whether a line of excitation belongs to the train as drawn: tooth form and loads, no other deviations."""
    return not causes or any(not cause.startswith("deviations.") or _is_profile(cause) for cause in causes)


def _is_profile(path: str) -> bool:
    """Whether a path is that of a profile error; an error that turns with a member has a name of the user's."""
    return path.split(".")[-1] == "profile" and ".errors." not in path
