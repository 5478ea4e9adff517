"""Deviations from nominal: the tables of the file, one field a kind.

A kind of deviation is a field of `MemberDeviationsTable` (`deviations.MEMBER.KIND`) or of `MeshDeviationsTable`
(`deviations.meshes.A-B.KIND`, of `errors` with a name behind it). The type of the field gives its form, units and
shorthand, the description is its row in docs/reference/model-file.md, `DeviationKind` in the annotation the rest.
Shorthand, normalisation, checks, error messages, JSON Schema and the page read these fields. The effect of a kind on
the train stands in `train/deviations.py`, under the same key.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal, Self, get_args

from pydantic import Field, ValidationInfo, model_validator

from ..errors import ModelError
from .schema_fields import ListsUnit, PerPlanet, SchemaTable, Unit, key
from .written_numbers import SMALL

Error = Annotated[PerPlanet, Unit("length", many=True, likely=SMALL)]
Angle = Annotated[PerPlanet, Unit("angle", many=True)]
PitchLists = tuple[tuple[float, ...], ...]  # [m], one list for each planet or one for all, one entry for each tooth


@dataclass(frozen=True, slots=True, kw_only=True)
class DeviationKind:
    """Properties of a kind of deviation beyond its type.

    check : (path, value, teeth of the member or None, number of planets); raises ModelError. It comes after the
        check that lists of numbers have one entry per planet.
    """

    check: Callable[[str, Any, int | None, int], None] | None = None


# displaced features --------------------------------------------------------------------------------------------------


class VectorTable(SchemaTable):
    """A vector: amplitude and phase, or components."""

    bare: ClassVar[str] = "amplitude"

    @model_validator(mode="after")
    def _complete(self) -> Self:
        """Refuse a vector without any component, or a phase without amplitude."""
        given = {name for name in ("amplitude", "phase", "x", "y", "z") if getattr(self, name) is not None}
        if "phase" in given and "amplitude" not in given:
            raise ModelError("phase without amplitude", allowed="{amplitude, phase, from} or {x, y, z}")
        if not given:
            raise ModelError("says nothing", allowed="{amplitude, phase, from} or {x, y, z}")
        return self


class DisplacementTable(VectorTable):
    """A displaced feature: amplitude and phase, or x and y; z beside either."""

    amplitude: Error | None = key(None, "amplitude of the displacement")
    phase: Angle | None = key(None, "phase from the x axis of `from`; default 0")
    from_: Literal["own", "stage"] = key(
        "own", "which axis the phase counts from: the body's own x axis, or the stage's", alias="from"
    )
    x: Error | None = key(None, "displacement along x (radial)")
    y: Error | None = key(None, "displacement along y (tangential)")
    z: Error | None = key(None, "displacement along z")


class TiltTable(VectorTable):
    """A tilt of a body's seat: amplitude and phase of the axis it tilts about, or x and y."""

    amplitude: Angle | None = key(None, "amplitude of the tilt")
    phase: Angle | None = key(None, "phase from the x axis of `from`; default 0")
    from_: Literal["own", "stage"] = key(
        "own", "which axis the phase counts from: the body's own x axis, or the stage's", alias="from"
    )
    x: Angle | None = key(None, "tilt about x (radial)")
    y: Angle | None = key(None, "tilt about y (tangential)")
    z: Angle | None = key(None, "tilt about z")


class UnbalanceTable(SchemaTable):
    """Mass times eccentricity."""

    bare: ClassVar[str] = "amount"
    amount: Annotated[PerPlanet, Unit("unbalance", many=True)] = Field(description="mass times eccentricity")
    phase: Angle | None = key(None, "phase from the body's own x axis; default 0")


# pitch deviations ----------------------------------------------------------------------------------------------------


class PitchUnit(ListsUnit):
    """Annotation of lists of pitch deviations, or of the name of a file that holds one."""

    def read(self, value: object, info: ValidationInfo[Any] | None = None) -> PitchLists:
        """Return the lists [m], one for each planet or one for all."""
        return tuple(tuple(row) for row in self.rows(value, info))

    def forms(self, kind: str) -> list[dict[str, Any]]:
        """Return the schemas of one list, and of the name of a file."""
        return [*super().forms(kind), {"type": "string", "pattern": r"\.[A-Za-z0-9]+$"}]


def _check_pitch(path: str, pitch: PitchLists, teeth: int | None, planets: int) -> None:
    """Raise ModelError unless there is one deviation for each tooth, in one list or one for each planet."""
    if teeth is None:
        raise ModelError("has no teeth", path=path, allowed="a gear")
    if len(pitch) not in (1, max(planets, 1)):
        raise ModelError(f"{len(pitch)} lists", path=path, allowed=f"one list, or one for each of {planets} planets")
    for entries in pitch:
        if len(entries) != teeth:
            raise ModelError(f"{len(entries)} values", path=path, allowed=f"one for each of {teeth} teeth")


# the kinds -----------------------------------------------------------------------------------------------------------


class MemberDeviationsTable(SchemaTable):
    """Deviations of one member, one side of it, or one body."""

    run_out: DisplacementTable | None = key(None, "run-out; turns with the member")
    bearing_run_out: DisplacementTable | None = key(None, "run-out of its bearing seat; turns with the member")
    position: DisplacementTable | None = key(None, "pin position error; stands still in what carries the member")
    tilt: TiltTable | None = key(None, "misalignment; stands still in what carries the member")
    pitch: Annotated[
        PitchLists | None,
        PitchUnit("length", low=-1, high=1, lists=True, likely=SMALL),
        DeviationKind(check=_check_pitch),
    ] = key(
        None,
        "measured cumulative pitch deviations, one per tooth, positive = material missing; one list, or one per "
        "planet; or the name of a CSV file",
    )
    unbalance: UnbalanceTable | None = key(None, "unbalance; turns with the member")


class ProfileErrorTable(SchemaTable):
    """Profile error, a cosine of the mesh phase."""

    bare: ClassVar[str] = "amplitude"
    amplitude: Error = Field(description="amplitude, along the tooth normal")
    order: Annotated[int, Field(ge=1, le=1000)] = key(1, "order: multiple of the mesh frequency")
    phase: Annotated[PerPlanet | str, Unit("angle", many=True, words=("identical", "random"))] = key(
        "identical", "identical teeth, random, or given angles"
    )
    seed: Annotated[int, Field(ge=0)] | None = key(None, "seed of random phases")


class TurningErrorTable(SchemaTable):
    """Error of a mesh that turns with a member: a cosine of the angle of the member.

    The meshes of one member may so show its error each with its own amplitude, phase and sense, as published equations
    state it.
    """

    turns_with: str = Field(description="a gear of the mesh, or the carrier of the stage")
    amplitude: Error = Field(description="amplitude of the error")
    order: Annotated[int, Field(ge=1, le=1000)] = key(1, "waves in one turn of the member; default 1")
    phase: Angle | None = key(None, "of the wave where the x axis of the member points as `from` says; default 0")
    from_: Literal["pitch-point", "normal"] = key(
        "pitch-point",
        "from where the member's x axis counts: towards the pitch point, or along the tooth force on the member",
        alias="from",
    )
    direction: Literal["normal", "transverse"] = key("normal", "along the tooth normal or the base tangent")
    sense: Literal["opens", "closes"] = key("opens", "what a positive value does to the gap")
    flanks: Literal["loaded", "both"] = key("loaded", "on the loaded flank, or on the far one too, from its own normal")


class MeshDeviationsTable(SchemaTable):
    """Deviations of one mesh or one side of it."""

    profile: ProfileErrorTable | None = key(None, "profile error, a harmonic of the mesh frequency")
    gap: Error | None = key(None, "error of the tooth thickness, positive opens the gap")
    errors: dict[str, TurningErrorTable] = Field(
        default_factory=dict, description="errors [m] of this pair that turn with a member, by names of your own"
    )


class DeviationsTable(SchemaTable):
    """Deviations by full path: members `main.sun`, `main.sun.right`, `g1`; meshes `main.meshes.sun-planet[.left]`."""

    members: dict[str, MemberDeviationsTable] = Field(default_factory=dict, description="by member path")
    meshes: dict[str, MeshDeviationsTable] = Field(default_factory=dict, description="by mesh path")


Deviations = type[MemberDeviationsTable] | type[MeshDeviationsTable]


def kind_of(table: Deviations, name: str) -> DeviationKind:
    """Properties of one kind beyond its type."""
    found = (m for m in table.model_fields[name].metadata if isinstance(m, DeviationKind))
    return next(found, DeviationKind())


def bare_keys(table: Deviations) -> dict[str, str]:
    """Key that a bare number or text stands for, by kind: ``run_out = "20 um"`` is ``run_out.amplitude``."""
    forms = {
        name: next((form for form in get_args(field.annotation) if hasattr(form, "bare")), None)
        for name, field in table.model_fields.items()
    }
    return {name: form.bare for name, form in forms.items() if form is not None}
