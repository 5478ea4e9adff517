"""What a train still lacks for each verb: the same checks that the verbs make, made once, without their work."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cached_property

from ..errors import ConvergenceError, ModelError
from ..questions.modes.basis import mean_modes
from ..questions.response.excitation import mesh_tones, require_damping
from ..statics.equilibrium import compliance_of, require_balance
from ..statics.tangent import linear
from ..statics.unheld import standing_load
from ..system.assembly import assemble
from ..system.system import System
from ..system.tooth_pairs import loaded_mesh, mean_force, pair_of, tooth_warnings
from ..train.power import require_contact, require_flow
from ..train.train import Train
from ..warning_codes import CodedText, coded

__all__ = ["Readiness"]

_RESPONSE = ("equations", "inertia", "damping", "speed", "balance")
NEEDS: dict[str, tuple[str, ...]] = {
    "allocate": ("equations", "torque", "balance", "tolerances", "prices"),
    "campbell": ("equations", "inertia", "speed"),
    "contact": ("torque", "first_teeth"),
    "efficiency": ("flow", "contact_lines"),
    "matrices": ("equations", "inertia"),
    "modes": ("equations", "inertia"),
    "modulation": (*_RESPONSE, "ring"),
    "relief": ("torque", "any_teeth"),
    "sensitivity": ("equations", "inertia"),
    "sharing": (*_RESPONSE, "torque"),
    "stability": ("equations", "inertia", "speed"),
    "static": ("equations", "balance"),
    "steady": _RESPONSE,
    "stiffness": (),
    "sweep": _RESPONSE,
    "tolerance": ("equations", "torque", "balance", "tolerances"),
    "track": ("equations", "inertia"),
    "train_contact": ("equations", "torque", "teeth", "balance"),
    "transient": ("equations", "inertia", "speed", "balance"),
}
"""Verb -> what it needs, methods of `Readiness`; options may need less (``sharing --method static``) or more."""


class Readiness:
    """What one train lacks; every check is made once.

    train : resolved.
    """

    def __init__(self, train: Train) -> None:
        self.train = train
        self._found: dict[str, str] = {}

    def lacking(self) -> dict[str, list[str]]:
        """Verb -> what it still needs, messages with their paths; none where it is ready."""
        found: dict[str, list[str]] = {}
        for verb, needs in NEEDS.items():
            asked = needs if not self.problem("equations") else [need for need in needs if need not in _ASSEMBLED]
            found[verb] = list(dict.fromkeys(text for need in asked if (text := self.problem(need))))
        return found

    def problem(self, need: str) -> str:
        """Message of one need that is not met, else ""."""
        if need not in self._found:
            check: Callable[[], object] = getattr(self, need)
            try:
                check()
            except (ModelError, ConvergenceError) as error:
                self._found[need] = str(error)
            else:
                self._found[need] = ""
        return self._found[need]

    @cached_property
    def system(self) -> System:
        """The assembled train.  Raises ModelError where its equations cannot be written."""
        return assemble(self.train)

    @cached_property
    def teeth_said(self) -> tuple[CodedText, ...]:
        """Warnings of tooth contact of the first mesh of every pair that has teeth, and why a pair has no contact."""
        said: list[CodedText] = []
        for pair in dict.fromkeys(mesh.pair for mesh in self.train.meshes):
            mesh = next(mesh for mesh in self.train.meshes if mesh.pair == pair)
            if mesh.teeth is None:
                continue
            try:
                said += tooth_warnings(pair_of(self.train, mesh), mesh)
            except ModelError as error:
                said.append(coded("no-tooth-contact", str(error)))
        return tuple(dict.fromkeys(said))

    def equations(self) -> object:
        """Check that the train can be assembled."""
        return self.system

    def inertia(self) -> object:
        """Check that every free coordinate has mass, and that the mean system has modes."""
        self.system.require_inertia()
        return mean_modes(linear(self.system))

    def damping(self) -> None:
        """Check that something damps."""
        require_damping(self.system)

    def speed(self) -> object:
        """Check that the meshes have a frequency."""
        if self.train.kinematics.speed is None:
            raise ModelError("the speed of one member is missing", path="operation.speed", allowed="e.g. 1500 rpm")
        return None if self.problem("equations") else mesh_tones(self.system)

    def torque(self) -> None:
        """Check that torque passes a mesh."""
        if not mean_force(self.train, loaded_mesh(self.train)) > 0:
            raise ModelError("no torque loads the teeth", path="operation.torque", allowed="a torque of a member")

    def tolerances(self) -> None:
        """Check that a number of the file has a tolerance."""
        if not self.train.document.get("tolerance"):
            raise ModelError("no tolerance is given", path="tolerance", allowed='"PATH" = "normal(mean, deviation)"')

    def prices(self) -> None:
        """Check that a tolerance has grades with prices."""
        table = self.train.document.get("tolerance")
        if not (isinstance(table, Mapping) and table.get("cost")):
            raise ModelError("no grade has a price", path="tolerance.cost", allowed='"GRADE or distribution" = PRICE')

    def flow(self) -> None:
        """Check that power flows."""
        require_flow(self.train.kinematics)

    def contact_lines(self) -> None:
        """Check that the contact lines of every pair are known and touch."""
        for mesh in self.train.meshes:
            require_contact(mesh)

    def balance(self) -> None:
        """Check that the mean load works on no motion without stiffness."""
        require_balance(compliance_of(self.system).free, standing_load(self.system)[None], self.system)

    def ring(self) -> None:
        """Check that a stage has a ring for a sensor."""
        if not any(mesh.internal for mesh in self.train.meshes):
            raise ModelError("no stage has a ring for its planets to pass along", path="stages", allowed="a ring")

    def first_teeth(self) -> object:
        """Check that the first mesh that torque passes has teeth that can bear."""
        return pair_of(self.train, loaded_mesh(self.train))

    def any_teeth(self) -> object:
        """Check that some mesh has teeth that can bear."""
        return pair_of(self.train, next((m for m in self.train.meshes if m.teeth is not None), self.train.meshes[0]))

    def teeth(self) -> None:
        """Check that every pair has teeth that can bear."""
        for mesh in {mesh.pair: mesh for mesh in reversed(self.train.meshes)}.values():
            pair_of(self.train, mesh)


# needs that ask the assembled train: without it they say the same as `equations`
_ASSEMBLED = ("inertia", "damping", "balance")
