"""The tables of the micro-geometry of a flank. SI, as read; what is not named is None."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from .quantities import Unit
from .schema_links import Place, Table, key

__all__ = ["Flank", "Profile", "Relief", "Wave"]

Amount = Annotated[float, Unit("length", low=0)]
Lengths = Annotated[tuple[float, ...], Unit("length", lists=True)]


class Relief(Table):
    """Material taken off towards an edge of the flank: the tip, the lowest contact, or both ends of the face."""

    amount: Amount | None = key(None, "material missing at the edge, along the tooth normal")
    length: Amount | None = key(None, "where it fades: height of the tooth (radial); of end relief along the axis")
    shape: Literal["linear", "parabolic"] = key("linear", "linear or parabolic")


class Profile(Table):
    """A measured profile: material missing at heights below the tip circle, linear between."""

    below_tip: Lengths = Field(description="heights below the tip circle, rising")
    missing: Lengths = Field(description="material missing there, along the tooth normal, of any sign")


class Wave(Table):
    """A wave along the profile: A cos(2 pi order sigma + phase), sigma from the pitch point in base pitches."""

    amplitude: Amount = Field(description="amplitude A, along the tooth normal")
    order: Annotated[int, Field(ge=1, le=1000)] = key(1, "waves per base pitch")
    phase: Annotated[float, Unit("angle")] = key(0.0, "at the pitch point")


class Flank(Table):
    """Micro-geometry of the flanks of a gear; amounts are material missing along the tooth normal."""

    tip_relief: Relief | None = key(None, "tip relief")
    root_relief: Relief | None = key(None, "root relief, from the lowest point that the mate touches")
    end_relief: Relief | None = key(None, "relief of both ends of the face")
    crown: Amount | None = key(None, "lengthwise crowning: missing at both ends of the face, parabolic")
    slope: Place | None = key(None, "helix slope: missing at the right end less that at the left")
    profile: Profile | None = key(None, "measured profile deviation")
    wave: Wave | None = key(None, "wave along the profile")
