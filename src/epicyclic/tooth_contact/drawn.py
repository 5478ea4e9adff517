"""The pair of teeth that a mesh means, ready for loaded contact."""

from __future__ import annotations

from functools import lru_cache

from ..gears.outline import GearForm
from ..gears.tooth_pair import ToothPair
from .lines import Plane
from .pieces import Pair
from .tooth import ToothCompliance, tooth_compliance

__all__ = ["pair_of_teeth"]


def pair_of_teeth(
    teeth: ToothPair, *, internal: bool, base_helix: float, lean: int, slides: tuple[float, float] = (0.0, 0.0)
) -> Pair:
    """The pair as drawn, bodies rigid along the face.

    Parameters
    ----------
    teeth, internal, base_helix : as of `Mesh`.  lean : d h of gear a.  slides : of both faces along the axis [m].

    Raises
    ------
    ModelError : pointed or undercut teeth, no body under them.
    """
    paths = tuple(path.removesuffix(".flank") for path in teeth.paths)
    return Pair(
        plane=Plane(
            base_a=teeth.base_a,
            base_b=teeth.base_b,
            internal=internal,
            pressure_angle=teeth.pressure_angle,
            base_helix=base_helix,
            base_pitch=teeth.base_pitch,
            limits=teeth.limits,
            lean=lean,
            face_a=(teeth.face_a[0] + slides[0], teeth.face_a[1] + slides[0]),
            face_b=(teeth.face_b[0] + slides[1], teeth.face_b[1] + slides[1]),
        ),
        tooth_a=_tooth(teeth.form_a, paths[0]),
        tooth_b=_tooth(teeth.form_b, paths[1]),
        flank_a=teeth.flank_a,
        flank_b=teeth.flank_b,
        youngs_modulus=(teeth.form_a.youngs_modulus, teeth.form_b.youngs_modulus),
        poisson=(teeth.form_a.poisson, teeth.form_b.poisson),
        teeth=(teeth.form_a.teeth, teeth.form_b.teeth),
    )


@lru_cache(maxsize=64)
def _tooth(form: GearForm, path: str) -> ToothCompliance:
    return tooth_compliance(form, path=path)
