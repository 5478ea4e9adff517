"""`campbell`: natural frequencies over speed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..elements import Company, Drawing, Section, Table

if TYPE_CHECKING:
    import xarray as xr

ORDER = 40
_COLUMNS = 5


def tables(result: xr.Dataset) -> Sequence[Table]:
    """Natural frequencies [Hz] at five of the speeds."""
    speeds = result.relative_speed.values
    frequency = result.whirl_frequency.transpose("mode", "relative_speed").values
    columns: dict[str, Any] = {"mode": list(map(int, result.mode.values))}
    for at in np.unique(np.linspace(0, len(speeds) - 1, _COLUMNS).round().astype(int)):
        columns[f"{speeds[at]:.3g} x speed [Hz]"] = list(frequency[:, at])
    return [Table(title="Natural frequencies over speed", columns=columns)]


def sections(result: xr.Dataset, company: Company) -> Sequence[Section]:
    """The diagram; beside `modes` it stands among them."""
    from ..charts.modes import campbell

    if "modes" in company:
        return []
    parts = [Drawing(anchor="campbell", figure=campbell(result))]
    return [Section(anchor="modes", title="Vibration modes", parts=parts)]
