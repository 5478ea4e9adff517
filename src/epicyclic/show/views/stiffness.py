"""`stiffness`: mesh stiffness over a mesh cycle."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from ..elements import Company, Drawing, Section, Table

if TYPE_CHECKING:
    import xarray as xr

SERIES = "As it is computed with: a Fourier series. Ripples beside a bend are where the series ends, not of the teeth."

ORDER = 20


def tables(result: xr.Dataset) -> Sequence[Table]:
    """Mean, least and most stiffness of every mesh [N/um]."""
    history = result.mesh_stiffness.transpose("mesh", "mesh_phase").values * 1e-6
    columns: dict[str, Any] = {
        "mesh": list(map(str, result.mesh.values)),
        "mean [N/µm]": list(result.mean_mesh_stiffness.values * 1e-6),
        "least [N/µm]": list(history.min(axis=1)),
        "most [N/µm]": list(history.max(axis=1)),
    }
    return [Table(title="Mesh stiffness along the tooth normal", columns=columns)]


def sections(result: xr.Dataset, company: Company) -> Sequence[Section]:
    """The curves; beside a `check` they stand among the meshes of that."""
    from ..charts.train import mesh_stiffness

    if "check" in company:
        return []
    return [
        Section(
            anchor="meshes",
            title="Meshes",
            parts=[Drawing(anchor="stiffness", figure=mesh_stiffness(result), caption=SERIES)],
        )
    ]
