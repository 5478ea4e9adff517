"""Full contact in the equilibrium of a train: time an instant, residuals; and time of a table of mesh stiffness.

    python benchmarks/teeth_system.py

Medians of CPU time of one thread.  Hertz contact, 20 slices a face, 32 instants of a mesh cycle at the operating
torque, pieces built once.  The table: 20 loads and 50 phases of one helix, teeth known.
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = os.environ["OMP_NUM_THREADS"] = os.environ["MKL_NUM_THREADS"] = "1"

import statistics
import time
from collections.abc import Callable

import numpy as np
import table

from epicyclic.statics.contact_equilibrium import ContactEquilibrium, ContactProblem, contact_equilibrium
from epicyclic.statics.equilibrium import compliance_of, equilibrium
from epicyclic.statics.record import excitation
from epicyclic.system.assembly import assemble
from epicyclic.system.tooth_pairs import face_laws, mean_force, pair_of, with_three_rows
from epicyclic.teeth.loaded_contact import contact_table
from epicyclic.train.resolution import load

_INSTANTS, _TABLE = 32, 0.5


def rows(quick: bool) -> list[table.Row]:
    """Rows of the benchmark's table: what, here, target, whether it is met."""
    repeats = 1 if quick else 5
    return [row for name in ("ren2021", "xu2020") for row in (*_train(name, repeats), _table(name, repeats))]


def _train(name: str, repeats: int) -> list[table.Row]:
    train = load(name)
    system = assemble(with_three_rows(train))
    flexible, index = compliance_of(system), np.arange(_INSTANTS)
    acting = excitation(system, system.tones[0], index, _INSTANTS)
    cycles = np.repeat((index / _INSTANTS)[:, None], len(train.meshes), axis=1)
    models = face_laws(train)
    clock = time.process_time()
    ready = [(one.at(cycles[:, list(one.meshes)]), np.array(one.meshes)) for one in models]
    built = time.process_time() - clock
    given = ContactProblem(system=system, flexible=flexible, contacts=ready, gap=acting.gap, force=acting.force)

    def once() -> ContactEquilibrium:
        springs = equilibrium(flexible, stiffness=acting.stiffness, gap=acting.gap, force=acting.force)
        return contact_equilibrium(given, springs.displacement)

    each = 1e3 * _median(once, repeats) / _INSTANTS
    found = once()
    what = f"{name}, {len(train.meshes)} meshes in full contact"
    force = found.row_force.reshape(_INSTANTS, -1, 3).sum(axis=2)
    contact, balance = found.contact_residual.max(), found.force_residual.max()
    return [
        (f"{what}: an instant", f"{each:.1f} ms, pieces {1e3 * built / _INSTANTS:.1f} ms", "", ""),
        (
            f"{what}: residuals, force",
            f"contact {contact:.0e}, balance {balance:.0e}, {force.mean() / 1e3:.2f} kN a mesh",
            "<= 1e-11",
            "met" if max(contact, balance) <= 1e-11 else "MISSED",
        ),
    ]


def _table(name: str, repeats: int) -> table.Row:
    train = load(name)
    mesh = train.meshes[0]
    pair, force = pair_of(train, mesh), mean_force(train, mesh)
    took = _median(lambda: contact_table(pair, force), repeats)
    met = "met" if took <= _TABLE else "MISSED"
    return f"{name}, table of mesh stiffness", f"{took:.2f} s", f"<= {_TABLE:g} s", met


def _median(run: Callable[[], object], repeats: int) -> float:
    run()
    times = []
    for _ in range(repeats):
        clock = time.process_time()
        run()
        times.append(time.process_time() - clock)
    return statistics.median(times)


if __name__ == "__main__":
    table.main(rows, __doc__)
