"""The tables of operation, loads and deviations. SI, as read; members are named by full paths."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from ..errors import ModelError
from .quantities import Unit
from .schema_links import PerPlanet, Place, Table, key

__all__ = [
    "Deviations",
    "Displacement",
    "LoadCase",
    "MemberDeviations",
    "MeshDeviations",
    "Operation",
    "ProfileDeviation",
    "TiltDeviation",
    "Unbalance",
    "Vector",
]

Error = Annotated[PerPlanet, Unit("length", many=True)]
Angle = Annotated[PerPlanet, Unit("angle", many=True)]
Force = Annotated[float, Unit("force")]
Moment = Annotated[float, Unit("torque")]


class Operation(Table):
    """What drives, holds and loads the train; keys are full member paths."""

    held: tuple[str, ...] = key((), "members that do not turn")
    speed: dict[str, Annotated[float, Unit("speed")]] = Field(
        default_factory=dict, description="absolute speed by member, positive about +z"
    )
    torque: dict[str, Annotated[float | str, Unit("torque", words=("balance",))]] = Field(
        default_factory=dict, description="external torque by member, or balance"
    )
    power: dict[str, Annotated[float, Unit("power")]] = Field(
        default_factory=dict, description="external power by member, positive into the train"
    )
    gravity: Annotated[tuple[float, float, float], Unit("acceleration", lists=True, count=3)] | None = key(
        None, "acceleration in housing axes; true is 9.81 m/s^2 along -y"
    )


class Vector(Table):
    """A force in x, y, z."""

    x: Force = key(0.0, "along x")
    y: Force = key(0.0, "along y")
    z: Force = key(0.0, "along z")


class MomentVector(Table):
    """A moment about x, y, z."""

    x: Moment = key(0.0, "about x")
    y: Moment = key(0.0, "about y")
    z: Moment = key(0.0, "about z")


class LoadCase(Table):
    """An external force and moment on one member or body."""

    on: str = Field(description="member or body")
    force: Vector = key(Vector(), "force")
    moment: MomentVector = key(MomentVector(), "moment")
    frame: Literal["housing", "member"] = key("housing", "fixed in space, or turning with the member")
    at: Place = key(0.0, "axial place, from the centre of the member")


def _polar(table: Displacement | TiltDeviation) -> None:
    """Raise ModelError for a deviation that says nothing, or a phase without amplitude."""
    if table.phase is not None and table.amplitude is None:
        raise ModelError("phase without amplitude", allowed="{amplitude, phase, from} or {x, y, z}")
    if all(v is None for v in (table.amplitude, table.x, table.y, table.z)):
        raise ModelError("says nothing", allowed="{amplitude, phase, from} or {x, y, z}")


class Displacement(Table):
    """A displaced feature: amplitude and phase, or x and y; z beside either."""

    amplitude: Error | None = key(None, "amplitude")
    phase: Angle | None = key(None, "from the x axis of `from`; default 0")
    from_: Literal["own", "stage"] = key("own", "the body's own x axis, or the stage's", alias="from")
    x: Error | None = key(None, "along x (radial)")
    y: Error | None = key(None, "along y (tangential)")
    z: Error | None = key(None, "along z")

    @model_validator(mode="after")
    def _complete(self) -> Self:
        """Refuse half a vector."""
        _polar(self)
        return self


class TiltDeviation(Table):
    """A tilt of a body's seat: amplitude and phase of the axis it tilts about, or x and y."""

    amplitude: Angle | None = key(None, "amplitude")
    phase: Angle | None = key(None, "from the x axis of `from`; default 0")
    from_: Literal["own", "stage"] = key("own", "the body's own x axis, or the stage's", alias="from")
    x: Angle | None = key(None, "about x (radial)")
    y: Angle | None = key(None, "about y (tangential)")
    z: Angle | None = key(None, "about z")

    @model_validator(mode="after")
    def _complete(self) -> Self:
        """Refuse half a vector."""
        _polar(self)
        return self


class Unbalance(Table):
    """Mass times eccentricity."""

    amount: Annotated[PerPlanet, Unit("unbalance", many=True)] = Field(description="mass times eccentricity")
    phase: Angle | None = key(None, "from the body's own x axis; default 0")


class MemberDeviations(Table):
    """Deviations of one member, one side of it, or one body."""

    run_out: Displacement | None = key(None, "run-out; turns with the member")
    bearing_run_out: Displacement | None = key(None, "run-out of its bearing seat; turns with the member")
    position: Displacement | None = key(None, "stands still in what carries the member")
    tilt: TiltDeviation | None = key(None, "stands still in what carries the member")
    pitch: tuple[tuple[float, ...], ...] | None = key(
        None, "cumulative pitch deviations [m], one per tooth, positive = material missing; one list, or one per planet"
    )
    unbalance: Unbalance | None = key(None, "unbalance; turns with the member")


class ProfileDeviation(Table):
    """Profile error, a cosine of the mesh phase."""

    amplitude: Error = Field(description="amplitude, along the tooth normal")
    order: Annotated[int, Field(ge=1, le=1000)] = key(1, "order of the mesh frequency")
    phase: Annotated[PerPlanet | str, Unit("angle", many=True, words=("identical", "random"))] = key(
        "identical", "identical teeth, random, or given angles"
    )
    seed: Annotated[int, Field(ge=0)] | None = key(None, "seed of random phases")


class MeshDeviations(Table):
    """Deviations of one mesh or one side of it."""

    profile: ProfileDeviation | None = key(None, "profile error")
    gap: Error | None = key(None, "tooth thickness error, positive opens the gap")


class Deviations(Table):
    """Deviations by full path: members `main.sun`, `main.sun.right`, `g1`; meshes `main.meshes.sun-planet[.left]`."""

    members: dict[str, MemberDeviations] = Field(default_factory=dict, description="by member path")
    meshes: dict[str, MeshDeviations] = Field(default_factory=dict, description="by mesh path")
