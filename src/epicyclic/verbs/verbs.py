"""The verbs: a source in, a Dataset out.  What the command line, notebooks and studies call.

A source is the name of a ready drive, a path of a model file, a dict, or what has been loaded or assembled already.
Every verb takes ``overrides``, path -> value, as `load` does.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import ModelError
from ..studies.source import Overrides, Source, system_of, train_of

if TYPE_CHECKING:
    import xarray as xr

    from ..system.system import System
    from ..train.train import Train


__all__ = [
    "VERBS",
    "campbell",
    "check",
    "contact",
    "modes",
    "modulation",
    "relief",
    "sensitivity",
    "sharing",
    "stability",
    "static",
    "steady",
    "stiffness",
    "sweep",
    "track",
    "train_contact",
    "transient",
]

_SPEED_HINT = 'a speed of a member, e.g. speed.sun = "100 rpm"'


def check(source: Source, *, overrides: Overrides | None = None) -> xr.Dataset:
    """Everything derived from the model: speeds, torques, geometry, phases, and where each value came from."""
    from ..studies.check import check as run

    return run(train_of(source, overrides=overrides))


def stiffness(source: Source, *, overrides: Overrides | None = None, **options: Any) -> xr.Dataset:
    """Mesh stiffness over a mesh cycle; options of `epicyclic.studies.stiffness.stiffness`."""
    from ..studies.stiffness import stiffness as run

    return run(train_of(source, overrides=overrides), **options)


def modes(source: Source, *, overrides: Overrides | None = None, **options: Any) -> xr.Dataset:
    """Natural frequencies, mode shapes, kinds and energy shares; options of `epicyclic.analyses.modes.modal.modal`."""
    from ..analyses.modes.modal import modal as run

    return run(system_of(source, overrides=overrides), **options)


def campbell(
    source: Source,
    *,
    overrides: Overrides | None = None,
    relative_speeds: Sequence[float] | None = None,
    **options: Any,
) -> xr.Dataset:
    """Natural frequencies over speed, by default from standstill to twice the operating speed.

    Further options are those of `epicyclic.analyses.modes.campbell.campbell`.

    Raises
    ------
    ModelError : the model is wrong, or says no speed.
    """
    from ..analyses.modes.campbell import campbell as run

    system = system_of(source, overrides=overrides)
    if not system.tones:
        raise ModelError("a Campbell diagram needs a speed", path="operation.speed", allowed=_SPEED_HINT)
    speeds = [2 * point / 40 for point in range(41)] if relative_speeds is None else relative_speeds
    return run(system, relative_speeds=speeds, **options)


def static(source: Source, *, overrides: Overrides | None = None, **options: Any) -> xr.Dataset:
    """Static equilibrium over the record, meshes unilateral; options of `epicyclic.analyses.static.static.static`."""
    from ..analyses.static.static import static as run

    return run(system_of(source, overrides=overrides), **options)


def steady(
    source: Source, *, overrides: Overrides | None = None, contact_loss: bool = False, **options: Any
) -> xr.Dataset:
    """Steady response at one speed; options of `epicyclic.analyses.steady.steady.steady`.

    Parameters
    ----------
    contact_loss : whether teeth may part and touch again; options are then those of
        `epicyclic.analyses.contact_loss.steady.contact_steady`.
    """
    if contact_loss:
        from ..analyses.contact_loss.steady import contact_steady

        return contact_steady(system_of(source, overrides=overrides), **options)
    from ..analyses.steady.steady import steady as run

    return run(system_of(source, overrides=overrides), **options)


def sharing(source: Source, *, overrides: Overrides | None = None, **options: Any) -> xr.Dataset:
    """Load-sharing coefficients by named definitions; options of `epicyclic.analyses.sharing.sharing.sharing`."""
    from ..analyses.sharing.sharing import sharing as run

    return run(system_of(source, overrides=overrides), **options)


def sweep(
    source: Source,
    *,
    overrides: Overrides | None = None,
    start: float | str | None = None,
    stop: float | str | None = None,
    points: int | None = None,
    contact_loss: bool = False,
    **options: Any,
) -> xr.Dataset:
    """Steady response over speed; further options are those of `epicyclic.analyses.steady.sweep.sweep`.

    Parameters
    ----------
    start, stop : lowest and highest mesh frequency, of the first mesh [Hz], or text with a unit: "600 Hz", "100 rpm" of
        the first member whose speed the model gives, "50 %" of the operating speed.  None: a fifth of the lowest, 1.2
        times the highest of the natural frequencies and the mesh frequency.  points : number of speeds, 200 where None.
    contact_loss : teeth part and touch again, on either flank: run-up, coast-down and all branches; options then are
        those of `epicyclic.analyses.contact_loss.sweep.contact_sweep`.

    Raises
    ------
    ModelError : the model is wrong, or says no speed, torque or damping.
    """
    from ..analyses.steady.sweep import sweep as linear

    train, system = _read(source, overrides)
    if start is not None or stop is not None or points is not None:
        options["mesh_frequency"] = _frequencies(system, start, stop, points or 200, train=train)
    if contact_loss:
        from ..analyses.contact_loss.sweep import contact_sweep

        return contact_sweep(system, **options)
    return linear(system, **options)


def transient(
    source: Source,
    *,
    overrides: Overrides | None = None,
    torque: str | Path | None = None,
    start: Any = "equilibrium",
    **options: Any,
) -> xr.Dataset:
    """Motion over time; further options are those of `epicyclic.analyses.transient.transient.transient`.

    Parameters
    ----------
    torque : a CSV file, ``time [s], sun [N m], ...``, of external torques of members.
    start : ``equilibrium``, ``rest``, a state, a result of this verb, or the .nc file of one.

    Raises
    ------
    ModelError : the model, the file or an option is wrong.
    """
    from ..analyses.transient.transient import transient as run

    if torque is not None:
        options["history"] = _history(torque)
    if isinstance(start, (str, Path)) and Path(start).suffix == ".nc":
        from ..results.dataset import load_result

        start = load_result(start)
    return run(system_of(source, overrides=overrides), start=start, **options)


def _history(path: str | Path) -> Any:
    """Torques of a CSV file as the analysis takes them."""
    import numpy as np

    from ..analyses.transient.scenario import History
    from ..model.history import read_history

    table = read_history(path)
    return History(
        time=np.array(table.time),
        torque={name: np.array(values) for name, values in table.torque.items()},
        where=tuple(f"{path}, line {line}" for line in table.line),
    )


def modulation(source: Source, *, overrides: Overrides | None = None, **options: Any) -> xr.Dataset:
    """Vibration at a fixed place beside the ring, its lines by family and cause.

    Options are those of `epicyclic.studies.modulation.modulation`.
    """
    from ..studies.modulation import modulation as run

    return run(system_of(source, overrides=overrides), **options)


def stability(
    source: Source,
    *,
    overrides: Overrides | None = None,
    start: float | str | None = None,
    stop: float | str | None = None,
    points: int | None = None,
    over: str | None = None,
    values: Sequence[Any] | None = None,
    **options: Any,
) -> xr.Dataset:
    """Floquet multipliers over speed, and over a second parameter where one is named, with boundaries by averaging.

    Further options are those of `epicyclic.analyses.stability.stability.stability`, and of
    `epicyclic.studies.stability.stability_map` with a second parameter.

    Parameters
    ----------
    start, stop, points : mesh frequencies as of `sweep`.
    over : path in the model file, or ``variation`` or ``damping``, a factor; values : those it takes.

    Raises
    ------
    ModelError : the model is wrong, or says no speed; one of `over` and `values` without the other.
    """
    from ..analyses.stability.stability import stability as run

    if (over is None) != (values is None):
        raise ModelError("a path and its values go together", path="over, values", given=f"{over}, {values}")
    train, system = _read(source, overrides)
    if over is not None and values is not None:
        from ..studies.stability import stability_map

        speeds = options.pop("mesh_frequency", None)
        speeds = _frequencies(system, start, stop, points or 100, train=train) if speeds is None else speeds
        return stability_map(source, over, values, speeds, overrides=overrides, **options)
    if start is not None or stop is not None or points is not None:
        options["mesh_frequency"] = _frequencies(system, start, stop, points or 200, train=train)
    return run(system, **options)


def sensitivity(source: Source, *, overrides: Overrides | None = None, **options: Any) -> xr.Dataset:
    """What moves a natural frequency or a mesh force most; options of `epicyclic.studies.sensitivity.sensitivity`."""
    from ..studies.sensitivity import sensitivity as run

    return run(train_of(source, overrides=overrides), **options)


def track(source: Source, *, overrides: Overrides | None = None, **options: Any) -> xr.Dataset:
    """Natural frequencies along a number of the model file; options of `epicyclic.studies.tracking.track`."""
    from ..studies.tracking import track as run

    return run(train_of(source, overrides=overrides), **options)


def _read(source: Source, overrides: Overrides | None) -> tuple[Train | None, System]:
    """The Train of a source, None where it is assembled already, and its System."""
    from ..system.system import System

    if isinstance(source, System):
        return None, system_of(source, overrides=overrides)
    train = train_of(source, overrides=overrides)
    return train, system_of(train)


def _frequencies(
    system: System,
    start: float | str | None,
    stop: float | str | None,
    points: int,
    *,
    train: Train | None = None,
) -> Sequence[float]:
    """Evenly spaced mesh frequencies [Hz]."""
    import numpy as np

    from ..analyses.modes.eigen import eigen
    from ..analyses.static.record import reference_tone
    from ..studies.speeds import mesh_frequency

    if not system.tones:
        raise ModelError("a sweep needs a speed", path="operation.speed", allowed=_SPEED_HINT)
    omega = eigen(system).omega
    tone = float(reference_tone(system))
    known = [tone, *(omega[omega > 0] / (2 * np.pi))]
    start, stop = (
        None if end is None else mesh_frequency(end, path=path, tone=tone, train=train)
        for end, path in ((start, "--from"), (stop, "--to"))
    )
    low = 0.2 * min(known) if start is None else start
    high = max(1.2 * max(known), low) if stop is None else stop
    if not 0 < low <= high:
        raise ModelError(
            "the range is empty", path="--from, --to", given=f"{low:g} Hz to {high:g} Hz", allowed="0 < from <= to"
        )
    return [float(frequency) for frequency in np.linspace(low, high, points)]


def contact(source: Source, *, overrides: Overrides | None = None, **options: Any) -> xr.Dataset:
    """Loaded tooth contact of one mesh; options of `epicyclic.studies.tooth_contact.contact`."""
    from ..studies.tooth_contact import contact as run

    return run(train_of(source, overrides=overrides), **options)


def relief(source: Source, *, overrides: Overrides | None = None, **options: Any) -> xr.Dataset:
    """The best relief and lead modification; options of `epicyclic.studies.relief.relief`."""
    from ..studies.relief import relief as run

    return run(source, overrides=overrides, **options)


def train_contact(source: Source, *, overrides: Overrides | None = None, **options: Any) -> xr.Dataset:
    """Tooth contact of all meshes at once, in the equilibrium of the train.

    Options are those of `epicyclic.studies.train_tooth_contact.train_contact`.
    """
    from ..studies.train_tooth_contact import train_contact as run

    return run(train_of(source, overrides=overrides), **options)


VERBS: Mapping[str, Callable[..., xr.Dataset]] = {
    "check": check,
    "stiffness": stiffness,
    "contact": contact,
    "relief": relief,
    "train_contact": train_contact,
    "modes": modes,
    "campbell": campbell,
    "static": static,
    "steady": steady,
    "sharing": sharing,
    "sweep": sweep,
    "sensitivity": sensitivity,
    "track": track,
    "modulation": modulation,
    "stability": stability,
    "transient": transient,
}
