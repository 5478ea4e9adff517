"""Steady response to mesh and shaft orders by matrix-free harmonic balance, linear contact.

Options of its verbs, those with contact loss among them.
"""

from dataclasses import dataclass
from typing import Annotated, Literal

from ...options import (
    Folder,
    FrameSpeed,
    MeshFrequencies,
    Option,
    Range,
    RelativeSpeed,
    RelativeSpeeds,
    Resume,
    ShaftOrders,
    ShaftTones,
    Start,
    Stop,
)

Unstable = Literal["replace", "report", "ignore"]
"""What becomes of motions that are not stable.

``replace``: branch switching, at last integration in time.  ``report``: each stays and its stability is reported; a run
goes on along its branch, and from the end of one to the nearest motion, of stable ones if there are.  ``ignore``: as
that, and stability is not computed.
"""

FIGURES = {
    "contact_sweep": ("contact-sweep",),
    "steady": ("steady-forces", "steady-range", "steady-errors", "sensors"),
    "sweep": ("sweep", "waterfall", "bearings", "error-sweep", "sensors"),
}
"""Kind of result -> names of its figures."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SteadyOptions:
    """Options of the steady response at one speed.

    shaft_tones : None: those that make four phases with one mesh tone, three with two.  The others, the weakest, are
        superposed linearly: a warning names them and what that leaves unbalanced.
    """

    relative_speed: RelativeSpeed = 1.0
    samples: Annotated[
        int, Option("Phases of a mesh cycle in the result of linear contact.", least=1, default="64")
    ] = 64
    method: Annotated[
        Literal["exact", "superposition"],
        Option("Of linear contact: coupled, or every frequency alone on the mean system.", default="exact"),
    ] = "exact"
    contact_loss: Annotated[bool, Option("Teeth only push; they part and touch again.")] = False
    shaft_orders: Annotated[
        bool, Option("With --contact-loss: count run-outs and other shaft orders.", default="yes")
    ] = True
    shaft_tones: ShaftTones = None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SweepOptions:
    """Options of a sweep over speed.

    frame_speed : whether the frame of the coordinates turns faster with the sweep (``kinematic``), as the train does,
        or gyroscopic and centripetal terms stay those of the operating speed (``operating``).
    orders : shaft lines are reported around so many mesh orders, and combinations of mesh frequencies up to so many, at
        most 32 of each.  tolerance : the truncation is below 30 times that.
    forces_alone : only mesh forces are measured, and the motion at the mesh orders, ``displacement_harmonic`` [m],
        complex; other motion and link forces are nan.
    harmonics : None: 16 to 48, as each point needs.
    shaft_orders : with contact loss a point at which they change the contact is a torus begun at the motion reached;
        one that fails, and a motion that is not stable or not periodic, holds nan and says so.
    shaft_tones : phases of that torus beside the mesh tones, None: 1; 30 ms a speed with one, ten times that with two.
        Other lines are superposed, ``superposed_error`` says what that leaves.
    """

    start: Start = None
    stop: Stop = None
    points: Annotated[int | None, Option("Number of speeds.", least=1, most=100_000, default="200")] = None
    range: Range = None
    mesh_frequency: MeshFrequencies = None
    relative_speed: RelativeSpeeds = None
    frame_speed: FrameSpeed = "kinematic"
    shaft_orders: ShaftOrders = True
    orders: Annotated[
        int, Option("Mesh orders whose amplitudes are reported, of linear contact.", least=1, most=100, default="12")
    ] = 12
    tolerance: Annotated[
        float,
        Option("Relative residual of the harmonics kept, of linear contact.", least=1e-14, most=0.1, default="1e-6"),
    ] = 1e-6
    contact_loss: Annotated[bool, Option("Teeth part and touch again: run-up, coast-down, all branches.")] = False
    unstable: Annotated[
        Unstable, Option("With --contact-loss: replace motions that are not stable, or report them.", default="replace")
    ] = "replace"
    harmonics: Annotated[
        int | None,
        Option("With --contact-loss: harmonics where teeth part.", least=1, most=192, default="as each point needs"),
    ] = None
    shaft_tones: ShaftTones = None
    folder: Folder = None
    resume: Resume = False
    forces_alone: bool = False

    @property
    def range_taken(self) -> dict[str, str]:
        """The range as a result records it; nothing where speeds are given."""
        given = self.mesh_frequency is not None or self.relative_speed is not None
        return {} if given else {"speed_range": self.range or "operation"}
