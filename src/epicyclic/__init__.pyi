"""Names of the package: `__init__.py` reads where each is from, and imports it when it is first used.

The verbs are written by `python docs/make_pages.py` from the dataclasses of their options.
"""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from .audits.audit import audit as audit
from .engine.source import Overrides, Source
from .errors import ConvergenceError as ConvergenceError
from .errors import ModelError as ModelError
from .questions.modulation.spectrum import Transfer, Window
from .questions.studies.compare import compare as compare
from .questions.studies.parameter_studies import vary as vary
from .questions.studies.verbs import study as study
from .questions.transient.scenario import History
from .results.dataset import load_result as load_result
from .results.dataset import save_result as save_result
from .results.dataset import to_json as to_json
from .results.files import save_matrices as save_matrices
from .rexs.export import write_rexs as write_rexs
from .rexs.import_train import read_rexs as read_rexs
from .show.plot import figure_names as figure_names
from .show.plot import plot as plot
from .show.report import write_report as write_report
from .system.assembly import assemble as assemble
from .system.system import System as System
from .terms import explain as explain
from .train.new_train import differential as differential
from .train.new_train import planetary as planetary
from .train.new_train import star as star
from .train.resolution import load as load
from .train.train import Train as Train

__all__: list[str]
__version__: str

# Verbs

def allocate(  # .questions.tolerance.verbs
    source: Source,
    *,
    overrides: Overrides | None = None,
    target: float | None = None,
    probability: float = 0.99,
    definition: Literal["mean-load", "mean-load-turning"] = "mean-load",
    samples: int = 16384,
    seed: int = 1,
    method: Literal["auto", "linear", "static"] = "auto",
    fresh_samples: int = 131072,
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """The cheapest grades of the drawing that keep K_gamma below a target in a share of the trains."""

def campbell(  # .questions.modes.verbs
    source: Source,
    *,
    overrides: Overrides | None = None,
    relative_speeds: Sequence[float] | None = None,
    damped: bool = False,
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """Natural frequencies over speed, standstill to twice the operating speed."""

def check(  # .questions.check.verbs
    source: Source,
    *,
    overrides: Overrides | None = None,
) -> xr.Dataset:
    """Speeds, torques, geometry, phases; every derived value and where it came from."""

def contact(  # .questions.flanks.verbs
    source: Source,
    *,
    overrides: Overrides | None = None,
    mesh: str | None = None,
    loads: Sequence[float] | str | None = None,
    load_points: int | None = None,
    samples: int | None = None,
    slices: int | None = None,
    tolerance: float = 0.01,
    corner: bool = False,
    linear_at: float | str | None = None,
    cycles: int | None = None,
    turns: int | None = None,
    of: str | None = None,
    torque: float | str | None = None,
    misalignment: float | str = 0.0,
    torque_end_a: Literal["left", "right"] | None = None,
    torque_end_b: Literal["left", "right"] | None = None,
    pitch_error: float | str = 0.0,
    profile_error: float | str = 0.0,
    deviations: bool = False,
    cycle: float | None = None,
    profile_phase: float | str | None = None,
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """Loaded tooth contact."""

def detune(  # .questions.studies.verbs
    source: Source,
    *,
    overrides: Overrides | None = None,
    mode: int | None = None,
    order: int | None = None,
    relative_speed: float | str = 1.0,
    band: float | str = 0.2,
    changes: int = 4,
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """Changes of the drawing that move a resonance away from operation, each computed again on the changed train."""

def efficiency(  # .questions.flanks.verbs
    source: Source,
    *,
    overrides: Overrides | None = None,
    friction: float | None = None,
    viscosity: float | str | None = None,
    roughness: float | str | None = None,
    sharing: Literal["uniform", "contact"] = "uniform",
) -> xr.Dataset:
    """Power lost in the meshes, and efficiency of the train at its operating point."""

def life(  # .questions.rating.verbs
    source: Source,
    *,
    overrides: Overrides | None = None,
    forces: Literal["static", "steady"] = "static",
    instants: int = 256,
    changes: bool = False,
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """Life of the rolling bearings that the drawing states by their parts, under static forces, over load cases."""

def load_factors(  # .questions.rating.verbs
    source: Source,
    *,
    overrides: Overrides | None = None,
    flanks: Literal["slices", "contact"] = "slices",
    tolerance: float = 0.01,
    material: Literal["case-hardened", "through-hardened", "nitrided", "nitrocarburised"] = "case-hardened",
    exponent: float | None = None,
    life: float | str | None = None,
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """What a gear rating asks."""

def matrices(  # .questions.check.verbs
    source: Source,
    *,
    overrides: Overrides | None = None,
    relative_speed: float | str = 1.0,
) -> xr.Dataset:
    """The mean linear system as matrices, for MATLAB, SciPy and others."""

def modes(  # .questions.modes.verbs
    source: Source,
    *,
    overrides: Overrides | None = None,
    relative_speed: float | str = 0.0,
    damped: bool = False,
    band: float | str | None = None,
) -> xr.Dataset:
    """Natural frequencies, kinds, shapes and energy shares; the resonances near operation."""

def modulation(  # .questions.modulation.verbs
    source: Source,
    *,
    overrides: Overrides | None = None,
    stage: str | None = None,
    sensor: float | str = 0.0,
    body: str | None = None,
    direction: Literal["radial", "tangential", "axial"] = "radial",
    window: Window | str | Path = "hann",
    width: float | str | None = None,
    transfer: Transfer | str | Path | None = None,
    through_planet: float = 0.0,
    mean_load: bool = False,
    radius: float | str | None = None,
    floor: float = 0.0001,
    turns: int = 1,
    samples: int | None = None,
    relative_speed: float | str = 1.0,
) -> xr.Dataset:
    """Vibration at a fixed place beside the ring."""

def output(  # .questions.output.verbs
    source: Source,
    *,
    overrides: Overrides | None = None,
    shaft: str | None = None,
    held: Sequence[str] | None = None,
    rated: float | str | None = None,
    share: float | str = 0.03,
    backlash_share: float | str = 0.005,
    points: int = 40,
    phases: int = 12,
    samples: int = 1024,
    seed: int = 1,
    friction: float | None = None,
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """The gearbox at its output, the other shafts locked."""

def relief(  # .questions.flanks.verbs
    source: Source,
    *,
    overrides: Overrides | None = None,
    vary: Mapping[str, object] | Sequence[str],
    mesh: str | Sequence[str] | None = None,
    torque: float | str | None = None,
    objectives: Sequence[Literal["lte", "load", "force_rms", "force_peak"]] = ("lte",),
    loads: Sequence[float] | str = (1.0,),
    load_points: int | None = None,
    start: float | str | None = None,
    stop: float | str | None = None,
    points: int = 30,
    population: int = 60,
    generations: int = 60,
    seed: int = 1,
    resume: str | Path | None = None,
    folder: str | Path | None = None,
    pick: int | None = None,
    samples: int | None = None,
    slices: int | None = None,
    tolerance: float = 0.01,
    misalignment: float | str = 0.0,
    corner: bool = False,
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """The best tip and root relief and lead modification of a mesh, or of all meshes of a train."""

def sensitivity(  # .questions.studies.verbs
    source: Source,
    *,
    overrides: Overrides | None = None,
    of: Literal["frequency", "force"] = "frequency",
    mode: int | None = None,
    mesh: str | None = None,
    paths: Sequence[str] | None = None,
    mesh_frequency: float | str | None = None,
    harmonic: int | None = None,
    relative_speed: float | str | None = None,
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """Which number of the model moves a natural frequency or a mesh force most."""

def sharing(  # .questions.sharing.verbs
    source: Source,
    *,
    overrides: Overrides | None = None,
    method: Literal["steady", "superposition", "static"] = "steady",
    cycles: int | None = None,
    turns: int | None = None,
    of: str | None = None,
    samples: int | None = None,
    relative_speed: float | str = 1.0,
    stored_cycles: int | None = None,
    limit: float | str | None = None,
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """Load-sharing coefficients, each by its named definition."""

def spectrum(  # .questions.rating.verbs
    source: Source,
    *,
    overrides: Overrides | None = None,
    train: Source | None = None,
    member: str | None = None,
    time: str | None = None,
    torque: str | None = None,
    speed: str | None = None,
    weight: str | None = None,
    torque_bins: int | Sequence[float] | str = 10,
    speed_bins: int | Sequence[float] | str = 4,
    exponent: float = 6.61,
    life: float | str | None = None,
    gap: float | str | None = None,
) -> xr.Dataset:
    """Load cases from a history of torque and speed."""

def stability(  # .questions.stability.verbs
    source: Source,
    *,
    overrides: Overrides | None = None,
    start: float | str | None = None,
    stop: float | str | None = None,
    points: int | None = None,
    range: Literal["operation", "modes"] | None = None,
    mesh_frequency: ArrayLike | None = None,
    relative_speed: ArrayLike | None = None,
    frame_speed: Literal["kinematic", "operating"] = "kinematic",
    variation: float | None = None,
    damping: float | None = None,
    over: str | None = None,
    values: Sequence[Any] | str | None = None,
    value_points: int = 21,
    folder: str | Path | None = None,
    resume: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> xr.Dataset:
    """Floquet stability over speed."""

def static(  # .statics.verbs
    source: Source,
    *,
    overrides: Overrides | None = None,
    cycles: int | None = None,
    turns: int | None = None,
    of: str | None = None,
    samples: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """Static equilibrium over the record; the teeth can only push."""

def steady(  # .questions.response.verbs
    source: Source,
    *,
    overrides: Overrides | None = None,
    relative_speed: float | str = 1.0,
    samples: int = 64,
    method: Literal["exact", "superposition"] = "exact",
    contact_loss: bool = False,
    shaft_orders: bool = True,
    shaft_tones: int | None = None,
) -> xr.Dataset:
    """Steady vibration at one speed."""

def stiffness(  # .questions.flanks.verbs
    source: Source,
    *,
    overrides: Overrides | None = None,
    samples: int = 256,
) -> xr.Dataset:
    """Mesh stiffness over a mesh cycle."""

def sweep(  # .questions.response.verbs
    source: Source,
    *,
    overrides: Overrides | None = None,
    start: float | str | None = None,
    stop: float | str | None = None,
    points: int | None = None,
    range: Literal["operation", "modes"] | None = None,
    mesh_frequency: ArrayLike | None = None,
    relative_speed: ArrayLike | None = None,
    frame_speed: Literal["kinematic", "operating"] = "kinematic",
    shaft_orders: bool = True,
    orders: int = 12,
    tolerance: float = 1e-06,
    contact_loss: bool = False,
    unstable: Literal["replace", "report", "ignore"] = "replace",
    harmonics: int | None = None,
    shaft_tones: int | None = None,
    folder: str | Path | None = None,
    resume: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> xr.Dataset:
    """Steady vibration over speed."""

def tolerance(  # .questions.tolerance.verbs
    source: Source,
    *,
    overrides: Overrides | None = None,
    samples: int = 131072,
    seed: int = 1,
    limit: Sequence[str] | Sequence[float] = (),
    method: Literal["auto", "linear", "static"] = "auto",
    sampler: Literal["sobol", "random"] = "sobol",
    effects: Literal["none", "shares", "all"] | None = None,
    reference: Mapping[str, float] | Sequence[str] | None = None,
    worst: str | Path | None = None,
    raw: bool = False,
    store: str | Path | None = None,
    resume: bool = False,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """The mesh-load factor K_gamma as a distribution, from the tolerances of the drawing."""

def track(  # .questions.studies.verbs
    source: Source,
    *,
    overrides: Overrides | None = None,
    over: str,
    start: float | str | None = None,
    stop: float | str | None = None,
    points: int = 41,
    modes: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """Natural frequencies along a number of the model, each mode followed; where they cross and where they veer."""

def transient(  # .questions.transient.verbs
    source: Source,
    *,
    overrides: Overrides | None = None,
    duration: float | str | None = None,
    cycles: float | None = None,
    start: float | str | None = None,
    stop: float | str | None = None,
    mesh_frequency: float | tuple[float, float] | None = None,
    torque: str | Path | None = None,
    history: History | None = None,
    torque_step: tuple[float, float] | str | None = None,
    torque_ramp: float | str | None = None,
    initial: str | Path | NDArray[np.float64] | xr.Dataset = "equilibrium",
    samples: int = 32,
    decimate: int = 1,
    contact: Literal["unilateral", "linear"] = "unilateral",
    method: Literal["rk4", "dop853", "radau"] = "rk4",
    folder: str | Path | None = None,
    resume: bool = False,
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """Motion over time."""
