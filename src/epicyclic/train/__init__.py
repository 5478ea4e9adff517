"""Document to Train: frozen data of bodies, connections, kinematics, phases, power; and a new train.

Depends on: document, teeth.  Modules of the Train itself know no document.  What a person says of a new train stands
here, so that the help of its command needs none of them.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Literal

from ..options import Option

Member = Literal["sun", "ring", "carrier"]
Number = float | str
"""A text with its unit, "10 mm", or a float in SI."""
ByMember = Number | Mapping[str, Number] | Sequence[str] | None
"""Of the driving member, or by member, ``{"sun": "1000 rpm"}`` or ``["sun=1000 rpm"]``."""
KIND_WORDS = "planetary, star, differential, parallel, compound, ravigneaux, wolfrom"


@dataclass(frozen=True, slots=True, kw_only=True)
class NewTrainOptions:
    """What a person says of a new train; what is missing is chosen, where it can be."""

    kind: Annotated[
        str, Option(f"One of {KIND_WORDS}; or several, in the order of the power.", metavar="KIND[,KIND...]")
    ] = "planetary"
    teeth: Annotated[
        str | Sequence[int] | None,
        Option("Teeth, 21/39/99; or --ratio, which looks for them.", metavar="SUN/PLANET/RING"),
    ] = None
    ratio: Annotated[float | None, Option("Input over output speed of the reducer, within 2 %; of all stages.")] = None
    planets: Annotated[int | str, Option("Planets.", metavar="NUMBER")] = 3
    held: Annotated[str | None, Option("What does not turn.", metavar="MEMBER", default="ring")] = None
    driver: Annotated[
        str | None, Option("What drives.", metavar="MEMBER", default="sun or pinion; ring with the sun held")
    ] = None
    speed: Annotated[
        ByMember, Option('Of what drives, "1000 rpm"; of a differential twice, "sun=1000 rpm".', metavar="SPEED")
    ] = None
    torque: Annotated[ByMember, Option('On what drives, "7.2 kN m"; or --power.', metavar="TORQUE")] = None
    power: Annotated[ByMember, Option('Of what drives, "750 kW".', metavar="POWER")] = None
    output_torque: Annotated[Number | None, Option('On what is driven, "300 N m".', metavar="TORQUE")] = None
    module: Annotated[Number | None, Option("Normal module.", metavar="LENGTH", default="preselected by load")] = None
    face_width: Annotated[Number | None, Option("Face width.", metavar="LENGTH", default="preselected by load")] = None
    centre_distance: Annotated[Number | None, Option("Centre distance; shifts follow.", metavar="LENGTH")] = None
    profile_shift: Annotated[ByMember, Option('Of a gear, "sun=0.3"; several times.', metavar="GEAR=SHIFT")] = None
    backlash: Annotated[Number | None, Option('At the output, input at rest, "3 arcmin".', metavar="ANGLE")] = None
    helix_angle: Annotated[Number | None, Option("Helix angle.", flag="--helix", metavar="ANGLE", default="0 deg")] = (
        None
    )
    pressure_angle: Annotated[Number | None, Option("Normal pressure angle.", metavar="ANGLE", default="20 deg")] = None
    title: Annotated[str | None, Option("Title of the model.", metavar="TEXT")] = None
