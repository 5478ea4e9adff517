"""Load factors of every mesh at one load case, and what all cases together do to a flank of every pair of gears.

No factor has a second engine here.  With the nominal load F of a mesh, the torque shared equally,

    K_gamma   largest mean load of a branch per equal share: `mean-load` of `sharing`, of a pair and side the largest
    K_v       largest force of the mesh per its own mean force: `dynamic_factor` of `steady`
    K_Hbeta   `face_load_factor`: of `static`, by the slices of the mesh; or of `contact` of the whole train
    K_Halpha  eps_alpha times the largest part of the mesh force on one pair of teeth (`pair_share` of `contact` of the
              mesh alone, with its pitch and profile deviations): largest load of a pair of teeth per the equal share of
              eps_alpha pairs, the transverse contact ratio

So that K_gamma K_v K_Hbeta K_Halpha is the largest load per length of contact line, per F over the mean length of all
lines, eps_alpha b / cos beta_b [maatar1996].  The definition of K_Halpha is derived here.  Spur teeth between contact
ratios of 1 and 2 have K_Halpha = eps_alpha, accurate or not: one pair of teeth carries all in single contact.  A rating
whose nominal stress has Z_eps [iso63362] takes K_Halpha / (eps_alpha Z_eps^2).  ISO 6336-1 says of K_Halpha what the
deviations of the teeth add to the largest load of a pair of accurate ones [iso6336, from memory]: that is
`accuracy_load_factor`, 1 of a file without pitch and profile deviations.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cache, partial
from math import ceil, cos, nan, sqrt
from typing import Any

import numpy as np
import xarray as xr

from ...document.document import read
from ...errors import ModelError
from ...results.dataset import dataset
from ...statics import StaticOptions
from ...statics.record import parallel_meshes, reference_tone
from ...statics.static import static
from ...system.assembly import assemble
from ...system.system import System, faces
from ...system.tooth_pairs import mean_force
from ...train.train import Mesh, Train
from ..flanks import ContactOptions
from ..flanks.pair_contact import pair_contact
from ..flanks.train_contact import train_contact
from ..response import SteadyOptions
from ..response.steady import steady
from ..sharing.definitions import known_mean_loads
from . import PITTING, LoadFactorOptions
from .load_spectrum import Columns, equivalent

FLANKS = (1, -1)
# Deviations by which the pairs of teeth of a mesh in contact differ.
_OF_TEETH = ("pitch", "profile")


# one case -------------------------------------------------------------------------------------------------------------


def case_factors(train: Train, options: LoadFactorOptions) -> xr.Dataset:
    """Load factors of every mesh of a train at its operating point.

    Returns
    -------
    Dataset : branch_load, k_gamma, dynamic_factor, face_load_factor, transverse_load_factor, load_factor_product (mesh)
        [1], face_load_basis (mesh); pair_torque (mesh_pair, mesh_gear) [N m], tooth_load_frequency (mesh_pair,
        mesh_gear) [Hz], flank (mesh_pair) +-1.  With contact accuracy_load_factor, direct_load_factor,
        coincidence_factor (mesh) [1], nominal_load_per_length, largest_load_per_length (mesh) [N/m], largest_pressure
        (mesh), largest_root_stress (mesh, mesh_gear) [Pa]; loads and stresses are without K_v.

    Raises
    ------
    ModelError : no torque, a locked train, and all that `steady`, `static` and `contact` refuse.
    ConvergenceError : no equilibrium.
    """
    system = assemble(train)
    if not any((train.kinematics.mesh_torque or {}).values()):
        raise ModelError("no torque loads the teeth", path="operation.torque", allowed="a torque of a member")
    loads, said = known_mean_loads(system)
    k_gamma = loads[0].copy()
    for group in parallel_meshes(system.meshes):
        k_gamma[group] = loads[0][group].max()
    moved = steady(system, SteadyOptions())
    columns: Columns = {
        "branch_load": ("mesh", loads[0]),
        "k_gamma": ("mesh", k_gamma),
        "dynamic_factor": ("mesh", moved.dynamic_factor.values),
        **_pair_columns(train),
    }
    contact = options.flanks == "contact"
    of_teeth, found = _contact_columns(train, system, options) if contact else _slice_columns(system)
    columns |= _product_columns(columns, of_teeth)
    warnings = [*system.warnings, *said, *(text for one in (moved, *found) for text in json.loads(one.warnings))]
    return dataset(
        columns,
        {
            "mesh": list(faces(system.meshes).name),
            "mesh_pair": _pairs(train),
            "mesh_gear": ["a", "b"],
        },
        verb="load_factors",
        options={"flanks": options.flanks, "exponent": options.exponent or PITTING[options.material]},
        warnings=list(dict.fromkeys(warnings)),
        provenance=system.provenance,
    )


def _pairs(train: Train) -> list[str]:
    return list(dict.fromkeys(mesh.pair for mesh in train.meshes))


def _pair_columns(train: Train) -> Columns:
    """Nominal torque of one mesh on both gears, how often a tooth of them is loaded, and the loaded flank, of pairs.

    A tooth of a gear meets all its mates of the pair in a turn relative to the carrier: of a sun as many as planets, of
    a planet one.
    """
    kinematics, torque, frequency = train.kinematics, [], []
    gearings, speed = {one.pair: one for one in kinematics.gearings}, kinematics.speed or {}
    of_pair = {pair: [mesh for mesh in train.meshes if mesh.pair == pair] for pair in _pairs(train)}
    for pair, meshes in of_pair.items():
        gearing = gearings[pair]
        b = (kinematics.mesh_torque or {}).get(pair, 0.0) / len({mesh.branch for mesh in meshes})
        torque.append((b * gearing.teeth_a / gearing.signed_b, b))
        frame = speed[gearing.carrier] if gearing.carrier else 0
        ends = ((gearing.a, [mesh.a for mesh in meshes]), (gearing.b, [mesh.b for mesh in meshes]))
        rates = [float(abs(speed[member] - frame)) / 60 * _mates(meshes, bodies) for member, bodies in ends]
        frequency.append(rates)
    over = ("mesh_pair", "mesh_gear")
    return {
        "pair_torque": (over, np.array(torque)),
        "tooth_load_frequency": (over, np.array(frequency)),
        "flank": ("mesh_pair", np.array([meshes[0].flank for meshes in of_pair.values()])),
    }


def _mates(meshes: list[Mesh], bodies: list[str]) -> int:
    """Gears that the same gear of a pair meets; bodies : that gear of every mesh."""
    return max(len({mesh.branch for mesh, body in zip(meshes, bodies, strict=True) if body == of}) for of in bodies)


def _slice_columns(system: System) -> tuple[Columns, list[xr.Dataset]]:
    """K_Hbeta by the slices of meshes; 1 of those in one piece."""
    face = faces(system.meshes)
    found = [static(system, StaticOptions())] if face.cut.any() else []
    factor = found[0].face_load_factor.values if found else np.full(len(face.name), nan)
    known = np.isfinite(factor)
    return {
        "face_load_factor": ("mesh", np.where(known, factor, 1.0)),
        "transverse_load_factor": ("mesh", np.ones(len(face.name))),
        "face_load_basis": ("mesh", np.where(known, "slices", "not known without slices").astype(object)),
    }, found


def _contact_columns(train: Train, system: System, options: LoadFactorOptions) -> tuple[Columns, list[xr.Dataset]]:
    """Factors, loads and stresses of tooth contact; of a pair that no torque passes those of the mesh alone are nan.

    The pressure is that of the mesh alone, as the square root of the largest load per length in the train to its own:
    that of a line contact.
    """
    alone = cache(partial(_alone, train, options.tolerance))
    # of the first mesh frequency, in which every mesh passes a whole cycle of its own
    cycles = max(ceil(reference_tone(system) / tone) for tone in system.tones if tone)
    how = ContactOptions(loads=(1.0,), tolerance=options.tolerance, cycles=cycles)
    whole = train_contact(train, how).sel(torque_factor=1.0)
    deviating = {error.mesh for error in train.mesh_errors if error.cause in _OF_TEETH}
    load, face = whole.largest_load_per_length.values, whole.shared_face.values
    values, found = np.full((5, len(train.meshes)), nan), dict[str, xr.Dataset]()
    for place, mesh in enumerate(train.meshes):
        force = mean_force(train, mesh)
        if not force > 0:
            continue
        first = next(one for one in train.meshes if (one.pair, one.side) == (mesh.pair, mesh.side))
        drawn = alone(first.name, False)
        real = alone(mesh.name, True) if mesh.name in deviating else drawn
        found[mesh.name] = real
        share, accurate = float(real.pair_share.max()), float(drawn.pair_share.max())
        nominal = force * cos(mesh.base_helix) / (mesh.contact_ratio * face[place])
        pressure = float(real.largest_pressure) * sqrt(load[place] / float(real.largest_load_per_length))
        values[:, place] = mesh.contact_ratio * share, share / accurate, nominal, pressure, load[place] / nominal
    names = ("transverse_load_factor", "accuracy_load_factor", "nominal_load_per_length", "largest_pressure")
    return {
        "face_load_factor": ("mesh", whole.face_load_factor.values),
        **{name: ("mesh", row) for name, row in zip((*names, "direct_load_factor"), values, strict=True)},
        "face_load_basis": ("mesh", np.full(len(load), "contact", dtype=object)),
        "largest_load_per_length": ("mesh", load),
        "largest_root_stress": (("mesh", "mesh_gear"), whole.largest_root_stress.values),
    }, [whole, *found.values()]


def _alone(train: Train, tolerance: float, mesh: str, deviations: bool) -> xr.Dataset:
    """Contact of one helix alone at its equal share, with the deviations of the file or as drawn."""
    options = ContactOptions(mesh=mesh, loads=(1.0,), tolerance=tolerance, deviations=deviations)
    return pair_contact(train, options).sel(torque_factor=1.0).isel(mesh=0)


def _product_columns(of_case: Mapping[str, Any], of_teeth: Columns) -> Columns:
    """The product of the factors, beside what contact gives directly with K_v, and why they differ.

    coincidence_factor : the direct one per the product with the mesh's own branch load in place of K_gamma.  Below 1 it
    says that the worst place along the face and the worst phase of the pairs of teeth do not meet; above 1, that the
    load is uneven along the line of a pair of teeth beyond its mean over the cycle, or that sides share unevenly.
    """
    own, k_gamma, k_v = (of_case[name][1] for name in ("branch_load", "k_gamma", "dynamic_factor"))
    teeth = of_teeth["face_load_factor"][1] * of_teeth["transverse_load_factor"][1]
    columns = {**of_teeth, "load_factor_product": ("mesh", k_gamma * k_v * teeth)}
    if "direct_load_factor" in of_teeth:
        direct = of_teeth["direct_load_factor"][1]
        columns["direct_load_factor"] = ("mesh", direct * k_v)
        with np.errstate(divide="ignore", invalid="ignore"):
            columns["coincidence_factor"] = ("mesh", direct / (own * teeth))
    return columns


# all cases ------------------------------------------------------------------------------------------------------------


def one_case(train: Train, options: LoadFactorOptions) -> xr.Dataset:
    """Load factors of a train at the case that it names, `operation` without one, along `case`; all of the time."""
    model = read(dict(train.document)).model
    duration = model.cases[model.case].duration if model.case else None
    found = case_factors(train, options).expand_dims(case=[model.case or "operation"])
    time = {"case_duration": ("case", [nan if duration is None else duration]), "case_share": ("case", [1.0])}
    return found.assign(time)


def over_duty(found: xr.Dataset, options: LoadFactorOptions) -> xr.Dataset:
    """Load factors of all cases (case, ...) with the load cycles and equivalent torques of every flank.

    T_eq = (sum n_i T_i^p / sum n_i)^(1/p) over the cases i that load the flank, by Miner's rule [iso63366]; n_i load
    cycles of a tooth.

    Returns
    -------
    Dataset : with load_cycles (case, mesh_pair, mesh_gear) [1], flank_cycles [1] and flank_equivalent_torque [N m]
        (mesh_pair, mesh_gear, loaded_flank), nan where the time of a case is not known, or its result; of a flank that
        no case loads the torque.
    """
    share, duration = found.case_share.values, found.case_duration.values
    time = duration if options.life is None else share * options.life
    torque, rate, flank = (found[name].values for name in ("pair_torque", "tooth_load_frequency", "flank"))
    exponent = options.exponent or PITTING[options.material]
    cycles = np.zeros((*torque.shape[1:], len(FLANKS)))
    mean = np.full_like(cycles, nan)
    for at in np.ndindex(torque.shape[1:]):
        size, loads = np.abs(torque[(slice(None), *at)]), rate[(slice(None), *at)]
        for side, which in enumerate(FLANKS):
            on = (flank[:, at[0]] == which) & (size > 0)
            of_flank = loads * on
            cycles[(*at, side)] = (of_flank * time).sum()
            weight = of_flank * share
            if weight.sum() > 0:  # of a case without a result it is nan
                mean[(*at, side)] = equivalent(size, weight, exponent, np.zeros(len(size), np.int64), 1)[0]
    over = ("mesh_pair", "mesh_gear", "loaded_flank")
    made = dataset(
        {
            "load_cycles": (("case", *over[:2]), rate * time[:, None, None]),
            "flank_cycles": (over, cycles),
            "flank_equivalent_torque": (over, mean),
            "case_duration": ("case", duration),
            "case_share": ("case", share),
        },
        {"loaded_flank": list(FLANKS)},
        verb="load_factors",
    )
    whole = found.assign_coords(made.coords).assign(made.data_vars)
    attrs = {name: value for name, value in found.attrs.items() if name not in ("of", "cases")}
    return whole.assign_attrs(attrs | {"verb": "load_factors"})
