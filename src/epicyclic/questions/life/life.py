"""Life of rolling bearings: loads of their elements under the forces of statics, rating life, Miner's sum over cases.

Forces are those along x and y of the link of a bearing, over a turn of the slowest body: with the weight as the carrier
turns, and run-outs at their own orders.  The life of a case is Miner's sum over its instants, 1/L = mean 1/L(t), by the
loads of elements and laminae [iso16281]; beside it L = (C/P)^p with P = (mean F^p)^(1/p) [iso281].  Forces along the
axis and moments count where the bearing follows the law of five rows.

Which race turns against the load follows from the motion: of the force as each race sees it, the one with the larger
mean over its sizes stands.  On a planet's pin the load goes round with the carrier, and the outer race turns.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from operator import attrgetter
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ...bearings.element_loads import LoadZone, contact_set, displacement, load_zone
from ...bearings.rating_life import (
    basic_life,
    distributed_life,
    dynamic_rating,
    equivalent_load,
    life_exponent,
    life_modification,
    static_rating,
    static_safety,
)
from ...bearings.rolling_bearing import RollingBearing, passing_frequencies
from ...engine.source import Drive, Duty
from ...errors import ConvergenceError, ModelError
from ...results.dataset import dataset
from ...statics.record import Record, record_of
from ...statics.static import held_train, quasi_static
from ...system.assembly import assemble, train_provenance
from ...system.system import Array, System
from ...train.train import DIRECTIONS, Link, Train
from ...warning_codes import CodedText, coded
from . import LifeOptions

if TYPE_CHECKING:
    import xarray as xr

# Places of a row and laminae of a roller, and loads at which a life is computed; between them log L is linear in log F.
_PLACES, _LAMINAE, _LOADS = 72, 30, 12
# Speed of a race against the other per the fastest body that is none, and a load per the static rating that is none.
_STANDS, _NO_LOAD = 1e-9, 1e-4


class BearingCase(NamedTuple):
    """A bearing in one load case.

    basic, reference, modified : lives [10^6 revolutions].  load : P [N].  speed : of one race against the other
    [rev/s].  turning : the race that turns against the load.  zone : under the largest force.  stiffness : radial, at
    the mean force [N/m].  frequencies : cage, outer, inner, element [Hz].
    """

    basic: float
    reference: float
    modified: float
    load: float
    speed: float
    turning: str
    zone: LoadZone
    stiffness: float
    safety: float
    frequencies: tuple[float, ...]


def life(source: Train | Duty, options: LifeOptions, *, progress: Callable[[float], None] | None = None) -> xr.Dataset:
    """Lives of all bearings that are stated by their parts.

    Parameters
    ----------
    source : one train, or the load cases of one drawing with their shares of the time; one that fails is left out.
    progress : called with the share done, 0..1.

    Returns
    -------
    Dataset : of each case (bearing, case) bearing_load [N], bearing_life_basic, bearing_life_reference,
        bearing_life_modified [s], race_speed [rad/s], turning_race, element_load (.., element) [N], element_pressure
        [Pa], load_zone_extent [1], bearing_stiffness [N/m], static_safety [1], cage_frequency, outer_race_frequency,
        inner_race_frequency, element_frequency [Hz], damage_share [1]; of all (bearing) bearing_duty_life_basic,
        bearing_duty_life_reference, bearing_duty_life_modified [s], bearing_rating, bearing_static_rating [N].

    Raises
    ------
    ModelError : no such bearing, a train that does not turn; of load cases where none is left.
    ConvergenceError : no equilibrium.
    """
    cases: Mapping[str, tuple[Train | Drive, float]]
    cases = {"operation": (source, 1.0)} if isinstance(source, Train) else source.cases
    tell, failed = progress or (lambda _: None), list[ModelError | ConvergenceError]()
    trains, found, shares = dict[str, Train](), dict[tuple[str, str], BearingCase](), list[float]()
    warnings = list[CodedText]()
    for number, (case, (given, share)) in enumerate(cases.items()):
        try:
            train = given if isinstance(given, Train) else given.train
            of_case, said = _bearings(train, options)
            trains[case], shares = train, [*shares, share]
            found |= {(name, case): one for name, one in of_case.items()}
            warnings += said
        except (ModelError, ConvergenceError) as error:
            failed.append(error)
            warnings.append(coded("case-failed", f"{case} is left out: {error}"))
        tell((number + 1) / len(cases))
    if not trains:
        raise failed[0]
    first = next(iter(trains.values()))
    bearings = {link.name: link for link in first.links if link.rolling is not None}
    warnings += [*_standing(found), *_not_counted(first, bearings)]
    return dataset(
        _columns(found, list(bearings.values()), list(trains), np.array(shares) / sum(shares)),
        {
            "bearing": list(bearings),
            "case": list(trains),
            "element": np.arange(1, 1 + max(one.zone.load.shape[1] for one in found.values())),
        },
        verb="life",
        options=asdict(options),
        provenance=train_provenance(first),
        warnings=list(dict.fromkeys(warnings)),
    )


def _bearings(train: Train, options: LifeOptions) -> tuple[dict[str, BearingCase], Sequence[CodedText]]:
    """Bearings of a train at one operating point by their names, and warnings of the train."""
    rolling = [link for link in train.links if link.rolling is not None]
    if not rolling:
        allowed = '"cylindrical roller" or another, and its parts'
        raise ModelError("no bearing is stated by its parts", path="stages.*.planet.bearing.type", allowed=allowed)
    if train.kinematics.speed is None:
        raise ModelError("the speed of one member is missing", path="operation.speed", allowed="e.g. 1500 rpm")
    system = assemble(train)
    system.require_turning()
    record = _record(system, options)
    forces, time = _row_forces(system, record), np.arange(record.instants) / record.samples / float(record.unit)
    found = {}
    for link in rolling:
        rows = [forces.get(f"{link.name}/{axis}", np.zeros(len(time))) for axis in DIRECTIONS[:5]]
        force = np.stack(rows if link.contacts is not None else rows[:2], axis=1)
        found[link.name] = _in_case(link, force, system, time)
    return found, system.warnings


def _record(system: System, options: LifeOptions) -> Record:
    """A turn of the slowest body that turns."""
    turns = {name: abs(turn) for name, turn in zip(system.dofs.bodies, system.body_turns, strict=True) if turn}
    if not turns:
        raise ModelError(
            "nothing turns, and no race against the other", path="operation.speed", allowed="a speed above 0"
        )
    of = min(turns, key=lambda name: turns[name])
    return record_of(system, cycles=None, turns=1, of=of, samples=options.instants, most=options.instants)


def _row_forces(system: System, record: Record) -> dict[str, Array]:
    """Force (T,) [N] of every row of the links, those of laws too, by its name."""
    names = [*system.links.name, *(row for group in system.groups for row in group.rows)]
    pieces = [
        np.hstack([system.links.stiffness * piece.link_deflection, piece.state.group_force])
        for piece in quasi_static(held_train(system), record)
    ]
    return dict(zip(names, np.concatenate(pieces).T, strict=True))


def _in_case(link: Link, force: Array, system: System, time: Array) -> BearingCase:
    """A bearing under forces along its own axes (T, 2), or in five rows (T, 5), [N, N m] at times (T,) [s]."""
    bearing = link.rolling
    assert bearing is not None
    turns = dict(zip(system.dofs.bodies, map(float, system.body_turns), strict=True))
    first, second = turns[link.first], turns[link.second] if link.second is not None else 0.0
    axes = first if link.kind == "bearing" and link.second is not None else _frame(link, system)
    size, wave = np.hypot(*force.T[:2]), force[:, 0] + 1j * force[:, 1]
    steady = [abs(np.mean(wave * np.exp(-2j * np.pi * (race - axes) * time))) for race in (first, second)]
    inner = "second" if link.kind == "bearing" and link.second is None else "first"
    stands = "first" if steady[0] >= steady[1] else "second"
    turning = "outer" if stands == inner else "inner"
    p, quiet = life_exponent(bearing), _NO_LOAD * static_rating(bearing)
    load = float(np.mean(size**p) ** (1 / p))
    reference = _life(bearing, force, turning) if max(load, abs(force).max()) > quiet else np.inf
    basic = float(basic_life(bearing, load)) if load > quiet else np.inf
    if bearing.contact_angle:  # X and Y of ISO 281 are not computed: the radial load that has the same life
        load, basic = float(equivalent_load(bearing, reference)), np.nan
    modified = np.nan
    if link.lubrication and np.isfinite(reference):
        kappa, contamination = link.lubrication
        stands_for = equivalent_load(bearing, reference)
        modified = reference * float(life_modification(bearing, stands_for, kappa=kappa, contamination=contamination))
    most = force[np.abs(force).max(axis=1).argmax() if force.shape[1] > 2 else size.argmax()]
    zone = load_zone(bearing, displacement(bearing, most if len(most) > 2 else [*most, 0.0]), laminae=_LAMINAE)
    return BearingCase(
        basic=basic,
        reference=float(reference),
        modified=modified,
        load=load,
        speed=abs(second - first),
        turning=turning,
        zone=zone,
        stiffness=_stiffness(bearing, float(size.mean())),
        safety=static_safety(bearing, zone),
        frequencies=tuple(map(abs, passing_frequencies(bearing, *((first, second)[:: 1 if inner == "first" else -1])))),
    )


def _frame(link: Link, system: System) -> float:
    """Speed of the frame in which a link has its axes [rev/s]."""
    return float(system.stage_turns.get(link.first.partition("/")[0], 0))


def _life(bearing: RollingBearing, force: Array, turning: Any) -> float:
    """Life [10^6 revolutions] by Miner's sum over forces (T, 2), or some of those (T, 5) [N, N m]."""
    options: dict[str, Any] = {"places": _PLACES, "laminae": _LAMINAE}
    if force.shape[1] > 2:
        some = force[:: max(1, len(force) // _LOADS)]
        return float(
            1
            / np.mean(1 / distributed_life(bearing, displacement(bearing, some, **options), turning=turning, **options))
        )
    size = np.hypot(*force.T)
    low, high = max(size.min(), 1e-3 * size.max()), size.max()
    loads = np.geomspace(low, high, _LOADS) if high > (1 + 1e-6) * low else np.array([high])
    lives = distributed_life(bearing, displacement(bearing, loads[:, None], **options), turning=turning, **options)
    each = np.exp(np.interp(np.log(np.maximum(size, low)), np.log(loads), np.log(lives)))
    return float(1 / np.mean(1 / each))


def _stiffness(bearing: RollingBearing, load: float) -> float:
    """Radial stiffness at a load [N/m], nan without."""
    if not load > _NO_LOAD * static_rating(bearing):
        return np.nan
    return float(contact_set(bearing).tangent(displacement(bearing, [load]))[0, 0])


def _standing(found: Mapping[tuple[str, str], BearingCase]) -> list[CodedText]:
    """Warnings of loaded bearings whose races stand against each other."""
    names = dict.fromkeys(name for (name, _), one in found.items() if one.speed <= _STANDS and one.zone.pressure > 0)
    text = "the races of {} do not turn against each other under load: false brinelling, no life"
    return [coded("races-stand", text.format(name)) for name in names]


def _not_counted(train: Train, links: Mapping[str, Link]) -> list[CodedText]:
    """A warning of bearings beside helical teeth that hold a thrust or a tilting moment rigidly, which is in no life.

    The thrusts of a planet in its two meshes cancel.
    """
    helical = {body for mesh in train.meshes if mesh.base_helix and not mesh.side for body in (mesh.a, mesh.b)}
    planets = {body.name for body in train.bodies if body.branch is not None}
    whose = {body.name: body.shaft_of or body.name for body in train.bodies}
    rigid = [
        link.name
        for link in links.values()
        if (loaded := helical & {whose[link.first], whose.get(link.second or "")})
        and np.isinf(link.stiffness[3 if loaded <= planets else 2 : 5]).any()
    ]
    if not rigid:
        return []
    text = f"{', '.join(rigid)}: helical teeth push or tilt what z, rx or ry hold rigidly; that load is in no life"
    return [coded("thrust-not-counted", text)]


def _columns(
    found: Mapping[tuple[str, str], BearingCase], links: list[Link], cases: list[str], shares: Array
) -> dict[str, tuple[Any, Any]]:
    """Variables of all bearings in all cases; shares : of the time (c,)."""
    each = ("bearing", "case")

    def table(value: Callable[[BearingCase], Any]) -> Any:
        return np.array([[value(found[link.name, case]) for case in cases] for link in links])

    speed = table(lambda one: one.speed)
    with np.errstate(divide="ignore", invalid="ignore"):
        lives = {
            name: np.where(speed > _STANDS, table(attrgetter(name)) * 1e6 / speed, np.inf)
            for name in ("basic", "reference", "modified")
        }
        damage = {name: shares / one for name, one in lives.items()}
        share = damage["reference"] / damage["reference"].sum(axis=1, keepdims=True)
        duty = {name: 1 / one.sum(axis=1) for name, one in damage.items()}
    most = max(one.zone.angle.size for one in found.values())

    def elements(values: Callable[[LoadZone], Array]) -> Any:
        """Values of the elements, nan behind those of a bearing that has less."""
        return table(lambda one: np.append(values(one.zone), np.full(most - one.zone.angle.size, np.nan)))

    frequencies = ("cage_frequency", "outer_race_frequency", "inner_race_frequency", "element_frequency")
    rolling = [link.rolling for link in links if link.rolling is not None]
    return {
        **{f"bearing_life_{name}": (each, one) for name, one in lives.items()},
        **{f"bearing_duty_life_{name}": ("bearing", one) for name, one in duty.items()},
        "damage_share": (each, np.nan_to_num(share)),
        "bearing_load": (each, table(lambda one: one.load)),
        "race_speed": (each, 2 * np.pi * speed),
        "turning_race": (each, table(lambda one: one.turning).astype(object)),
        "element_load": ((*each, "element"), elements(lambda zone: zone.load[zone.most[0]])),
        "element_angle": ((*each, "element"), elements(lambda zone: zone.angle)),
        "element_pressure": (each, table(lambda one: one.zone.pressure)),
        "load_zone_extent": (each, table(lambda one: one.zone.extent)),
        "bearing_stiffness": (each, table(lambda one: one.stiffness)),
        "static_safety": (each, table(lambda one: one.safety)),
        **{
            name: (each, values)
            for name, values in zip(frequencies, np.moveaxis(table(attrgetter("frequencies")), -1, 0), strict=True)
        },
        "bearing_rating": ("bearing", [dynamic_rating(one) for one in rolling]),
        "bearing_static_rating": ("bearing", [static_rating(one) for one in rolling]),
        "case_share": ("case", shares),
    }
