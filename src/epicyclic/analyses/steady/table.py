"""The table a sweep fills in, speed by speed, and the Dataset made of it: the same for every kind of sweep."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...system.faces import faces
from ...system.system import Array, System
from .excitation import Excitation
from .links import lateral
from .measures import Layout
from .reported_lines import Told, told_lines

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Table", "blank", "labelled", "layout_of"]

Index = NDArray[np.int64]

# every variable of numbers: what its rows are, and what they are told over besides speed
_ROWS: dict[str, tuple[str, ...]] = {
    "mesh_force_mean": ("mesh",),
    "mesh_force_rms": ("mesh",),
    "mesh_force_peak": ("mesh",),
    "mesh_force_minimum": ("mesh",),
    "mesh_force_peak_to_peak": ("mesh",),
    "dynamic_factor": ("mesh",),
    "mesh_force_order": ("mesh", "order"),
    "mesh_force_line": ("mesh", "line"),
    "amplitude": ("dof",),
    "acceleration_rms": ("dof",),
    "body_acceleration_rms": ("body",),
    "link_force_mean": ("link_row",),
    "link_force_rms": ("link_row",),
    "link_force_peak": ("link_row",),
    "link_force_peak_to_peak": ("link_row",),
    "bearing_force_mean": ("bearing",),
    "bearing_force_rms": ("bearing",),
    "bearing_force_peak": ("bearing",),
    "residual": (),
}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Table:
    """What a sweep fills in.

    labels : names along every dimension but speed.  values : arrays by name, speeds last, nan where nothing was found.
    harmonics : (P,) 0 where nothing was found.  status : (P,) what became of the point.
    lowest : (m, P) smallest force of every mesh row, slices apart [N].  told, layout : what is told.
    tones : (D,) mesh frequencies in orders of the first mesh's.
    """

    labels: Mapping[str, Sequence[Any]]
    values: Mapping[str, Array]
    harmonics: Index
    status: NDArray[np.object_]
    lowest: Array
    told: Told
    layout: Layout
    tones: Array

    def put(self, place: Index, found: Mapping[str, Array], good: NDArray[np.bool_]) -> None:
        """Write the measures of points `place` (P,), nan where they are not good."""
        for name, values in found.items():
            if name in self.values:
                self.values[name][..., place] = np.where(good, values, np.nan)


def layout_of(system: System, lines: Excitation, *, orders: int, shafts: bool) -> tuple[Layout, Told]:
    """What the rows of the signals of a System are, and the lines told of it."""
    face, dofs = faces(system.meshes), system.dofs
    axes, stages = lines.axis.tolist(), system.meshes.stage
    names = [stages[axes.index(axis)] for axis in range(len(lines.tones))]
    told = told_lines(lines, names, orders=orders, shafts=shafts)
    translation = dofs.expand.reshape(len(dofs.bodies), 6, -1)[:, :3]
    layout = Layout(
        axis=lines.axis[face.first],
        radius=dofs.radius,
        translation=translation,
        pairs=lateral(system),
        orders=orders,
        frequencies=told.frequency,
    )
    return layout, told


def blank(system: System, lines: Excitation, count: int, *, orders: int, shafts: bool) -> Table:
    """An empty table for `count` speeds; what has no rows (links, lines) is not in it."""
    layout, told = layout_of(system, lines, orders=orders, shafts=shafts)
    labels: dict[str, Sequence[Any]] = {
        "mesh": faces(system.meshes).name,
        "order": range(1, orders + 1),
        "line": told.label,
        "dof": system.dofs.names,
        "body": system.dofs.bodies if layout.translation.any() else (),
        "link_row": system.links.name,
        "bearing": [system.links.link[x] for x in layout.pairs[:, 0]],
    }
    shapes = {name: [len(labels[dim]) for dim in dims] for name, dims in _ROWS.items()}
    return Table(
        labels=labels,
        values={name: np.full((*shape, count), np.nan) for name, shape in shapes.items() if 0 not in shape},
        harmonics=np.zeros(count, dtype=np.int64),
        status=np.full(count, "", dtype=object),
        lowest=np.full((len(system.meshes.name), count), np.nan),
        told=told,
        layout=layout,
        tones=np.array([float(tone / lines.tone) for tone in lines.tones]),
    )


def labelled(
    table: Table,
    system: System,
    *,
    speed: Array,
    tone: float,
    verb: str,
    options: Mapping[str, Any],
    warnings: Sequence[str],
    further: Mapping[str, tuple[Sequence[str] | str, Any]] | None = None,
) -> xr.Dataset:
    """The Dataset of a filled table.

    Parameters
    ----------
    speed : (P,) relative; tone : mesh frequency of the first mesh at the operating speed [Hz].
    verb, options, warnings : as of `results.dataset`.  further : variables that only this kind of sweep has.
    """
    from ...results.dataset import dataset

    variables = {name: ((*_ROWS[name], "speed"), values) for name, values in table.values.items()}
    used = {dim for dims, _ in variables.values() for dim in dims}
    coords: dict[Hashable, Any] = {dim: list(names) for dim, names in table.labels.items() if dim in used}
    coords["mesh_tone"] = ("mesh", table.tones[table.layout.axis])
    if "line" in used:
        coords["line_order"] = ("line", np.array([float(f) for f in table.told.frequency]) / tone)
    return dataset(
        {
            **variables,
            "status": ("speed", table.status),
            "harmonics": ("speed", table.harmonics),
            **(further or {}),
        },
        {**coords, "speed": speed, "mesh_frequency": ("speed", speed * tone)},
        verb=verb,
        options=options,
        provenance=system.provenance,
        warnings=warnings,
        units={"speed": "1"},  # relative to the operating speed, not the rpm of `check`
    )
