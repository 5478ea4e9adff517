"""What bad input, kills, races and damage do to the package; prints what it counts.

    python benchmarks/hardening.py mutations 20000 | kills 100 | races 100 | damage 400

Each part runs in small in the tests.  A fault is whatever is no ModelError and no ConvergenceError.
"""

from __future__ import annotations

import atexit
import json
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import tomllib
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any
from xml.etree import ElementTree
from zipfile import BadZipFile

import numpy as np
import pandas as pd
from scipy.io import loadmat

import epicyclic
from epicyclic.errors import ConvergenceError, ModelError
from epicyclic.results.dataset import load_result, save_result

__all__ = ["COMMANDS", "damaged_file", "damages", "kills", "mutated", "mutations", "races"]

ROOT = Path(__file__).parents[1]
Table = dict[str, Any]
# seconds that check, modes and sharing of one mutated file may take together
_PATIENCE = 60

# model files ----------------------------------------------------------------------------------------------------------

_VALUES: tuple[Any, ...] = (
    *(
        0,
        1,
        -1,
        2,
        3,
        1e-300,
        1e300,
        1e17,
        -0.0,
        10**400,
        1e-9,
        float("inf"),
        True,
        False,
        "",
        " ",
        "inf",
        "-inf",
        "nan",
    ),
    *([], [[]], {}, [0], [1, 2], {"x": 1}, "sun", "main.sun", "ring", "planet", "left", "housing", "none", "energy"),
    *("contact-lines", "contact", "iso6336", "fit", "random", "balance", "1 mm", "0 mm", "-3 mm", "1e300 m", "5 deg"),
    *("90 deg", "1 kg", "1e-30 kg", "1e9 kg", "1 rpm", "0 rpm", "1e7 rad/s", "1 N", "1 N m", "[1, 2, 3] um", "[] um"),
    *("1e16 N/m", "1e-20 N/m", "2e7 N/m", "1 N/(mm um)", "3 %", "500 %", "0x10", "\u00e4", "\x1b[31m", "a" * 300),
    *({"file": "none.csv"}, {"deflection": "[0, 1] um", "force": "[0, 1] kN"}, {"cosine": [0.5]}, {"values": [1, 1]}),
    *({"amplitude": "1 um"}, {"x": "1 um", "y": "2 um"}, {"modal": 0.03}, {"count": 2, "clearance": "1 um"}),
)
_UNITS = ("m", "mm", "um", "kg", "g", "N", "kN", "N/m", "N/um", "rad", "deg", "rpm", "Hz", "%", "s", "N m", "kW", "")


def _paths(table: Table, before: tuple[str, ...] = ()) -> list[tuple[str, ...]]:
    found = []
    for name, value in table.items():
        found.append((*before, name))
        if isinstance(value, dict):
            found += _paths(value, (*before, name))
    return found


def _within(table: Table, path: tuple[str, ...]) -> Table:
    for name in path[:-1]:
        table = table[name]
    return table


def mutated(table: Table, rng: random.Random, keys: list[str]) -> Table:
    """A copy of the tables of a model file with one to three keys, values, units or tables changed.

    keys : words that may stand as a key.
    """
    table = json.loads(json.dumps(table))
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        path = rng.choice(_paths(table))
        inside, name = _within(table, path), path[-1]
        change = rng.choice(
            ("value", "value", "value", "scale", "scale", "unit", "unit", "drop", "name", "move", "add")
        )
        if change == "value":
            inside[name] = rng.choice(_VALUES)
        elif change == "scale":
            inside[name] = _scaled(inside[name], rng)
        elif change == "unit" and isinstance(inside[name], str):
            inside[name] = f"{inside[name].split(' ')[0]} {rng.choice(_UNITS)}"
        elif change == "drop":
            del inside[name]
        elif change == "name":
            inside[rng.choice(keys)] = inside.pop(name)
        elif change == "move":
            other = rng.choice(_paths(table))
            _within(table, other)[other[-1]] = json.loads(json.dumps(inside[name]))
        else:
            inside[rng.choice(keys)] = rng.choice(_VALUES)
        if not table:
            break
    return table


def _scaled(value: Any, rng: random.Random) -> Any:
    """A number, or the number of a text, times a power of ten, or of the other sign."""
    by = rng.choice((-1, 0, 0.5, 2, 10, 1e-3, 1e3, 1e-6, 1e6, 1e12, 1e-12))
    if isinstance(value, bool) or isinstance(value, dict):
        return value
    if isinstance(value, int | float):
        return type(value)(value * by)
    if isinstance(value, list):
        return [_scaled(one, rng) for one in value] * rng.choice((1, 1, 2))
    head, _, unit = str(value).partition(" ")
    try:
        return f"{float(head) * by:g} {unit}".strip()
    except ValueError:
        return value[::-1]


def _tables() -> list[Table]:
    drives = [path for path in (ROOT / "src/epicyclic/systems").glob("*.toml") if ".audit." not in path.name]
    files = sorted([*drives, *(ROOT / "tests/files/good").glob("*.toml")])
    return [tomllib.loads(path.read_text(encoding="utf-8")) for path in files]


@contextmanager
def _patience(seconds: int) -> Iterator[None]:
    """Raise TimeoutError in the block after so many seconds."""

    def ring(*_: object) -> None:
        raise TimeoutError(f"longer than {seconds} s")

    before = signal.signal(signal.SIGALRM, ring)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def _outcome(run: Callable[[], object]) -> str:
    try:
        run()
    except ModelError as error:
        str(error).encode("utf-8")
        return "refused"
    except ConvergenceError:
        return "no convergence"
    return "answered"


def mutations(count: int, seed: int = 1, *, report: Callable[[str], None] = print) -> Counter[str]:
    """Check, modes and sharing of mutated model files; what became of them.

    Faults are counted under ``fault``, and told with the seed of the file and the last line of the traceback.
    """
    tables = _tables()
    keys = sorted({name for table in tables for path in _paths(table) for name in path} | {"", "a b", "x", "radial"})
    verbs: dict[str, Callable[[Any], object]] = {
        "check": epicyclic.check,
        "modes": epicyclic.modes,
        "sharing": lambda train: epicyclic.sharing(train, cycles=2),
    }
    found: Counter[str] = Counter()
    for number in range(count):
        rng = random.Random(f"{seed} {number}")
        table = mutated(rng.choice(tables), rng, keys)
        train: Any = None
        for verb, run in {"load": lambda _: epicyclic.load(table), **verbs}.items():  # noqa: B023
            began = time.perf_counter()
            try:
                with warnings.catch_warnings(), np.errstate(all="ignore"), _patience(_PATIENCE):
                    warnings.simplefilter("ignore")
                    if verb == "load":
                        outcome = "refused"
                        train = epicyclic.load(table)
                        outcome = "answered"
                    else:
                        outcome = _outcome(lambda: run(train))  # noqa: B023
            except ModelError:
                pass
            except BaseException as error:
                if isinstance(error, KeyboardInterrupt):
                    raise
                outcome = "fault"
                frame = traceback.extract_tb(error.__traceback__)[-1]
                where = next(
                    (f for f in reversed(traceback.extract_tb(error.__traceback__)) if "epicyclic" in f.filename), frame
                )
                report(
                    f"fault: seed {seed} {number}, {verb}: {type(error).__name__}: {str(error)[:120]} "
                    f"at {Path(where.filename).name}:{where.lineno}"
                )
            found[f"{verb} {outcome}"] += 1
            found["fault"] += outcome == "fault"
            if time.perf_counter() - began > 5:
                report(f"slow: seed {seed} {number}, {verb}: {time.perf_counter() - began:.1f} s")
            if outcome != "answered" and verb == "load":
                break
    return found


# result files ---------------------------------------------------------------------------------------------------------


def damaged_file(raw: bytes, rng: random.Random) -> bytes:
    """The bytes of a file with a bit, a byte or a block changed, cut, put in, or bytes at the end."""
    data, at = bytearray(raw), rng.randrange(len(raw))
    kind = rng.choice(("bit", "bit", "byte", "block", "cut", "insert", "zero", "append", "bits"))
    if kind == "bit":
        data[at] ^= 1 << rng.randrange(8)
    elif kind == "bits":
        for _ in range(20):
            data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
    elif kind == "byte":
        data[at] = (data[at] + rng.randrange(1, 256)) % 256
    elif kind == "block":
        data[at : at + 64] = rng.randbytes(len(data[at : at + 64]))
    elif kind == "cut":
        del data[at:]
    elif kind == "insert":
        data[at:at] = rng.randbytes(rng.randrange(1, 20))
    elif kind == "zero":
        data[at : at + 512] = bytes(len(data[at : at + 512]))
    else:
        data += rng.randbytes(rng.randrange(1, 300))
    return bytes(data)


def damages(count: int, folder: Path, seed: int = 1) -> Counter[str]:
    """Damaged result files: how many are refused, loaded as they were, or with other numbers, or raise a fault."""
    whole, broken = folder / "whole.nc", folder / "broken.nc"
    save_result(epicyclic.modes("lin1999-n3"), whole)
    raw, saved, rng, found = whole.read_bytes(), load_result(whole), random.Random(seed), Counter[str]()
    for _ in range(count):
        data = damaged_file(raw, rng)
        broken.write_bytes(data)
        try:
            again = load_result(broken)
        except ModelError:
            found["refused"] += 1
        except Exception as error:
            found[f"fault {type(error).__name__}"] += 1
        else:
            same = again.identical(saved)
            found[
                "the bytes were the same" if data == raw else "loaded, same numbers" if same else "other numbers"
            ] += 1
    return found


# kills and races ------------------------------------------------------------------------------------------------------

# every verb that writes, and every kind of file: arguments, the last of them the file; `_sources` makes sources/
COMMANDS: dict[str, tuple[str, ...]] = {
    "allocate .toml": ("allocate", "ren2021", "--samples", "1024", "--fresh-samples", "1024", "-o", "out.toml"),
    "audit .csv": ("audit", "lin1999-n4", "-o", "out.csv"),
    "campbell .nc": ("campbell", "ren2021", "-o", "out.nc"),
    "check .json": ("check", "lin1999-n4", "-o", "out.json"),
    "check --resolved": ("check", "lin1999-n4", "--resolved", "-o", "out.toml"),
    "compare .xlsx": ("compare", "lin1999-n3", "lin1999-n4", "-o", "out.xlsx"),
    "contact .json": ("contact", "ren2021", "--samples", "4", "--slices", "4", "-o", "out.json"),
    "detune .nc": ("detune", "ren2021", "-o", "out.nc"),
    "efficiency .xlsx": ("efficiency", "wind-stage", "-o", "out.xlsx"),
    "export .rexs": ("export", "wind-stage", "-o", "out.rexs"),
    "figure .html": ("modes", "lin1999-n4", "--figure", "frequencies", "-o", "out.html"),
    "import .toml": ("import", "sources/train.rexs", "-o", "out.toml"),
    "life .nc": ("life", "sources/parts.toml", "--instants", "8", "-o", "out.nc"),
    "load-factors .rexs": ("load-factors", "wind-stage", "-o", "out.rexs"),
    "matrices .mat": ("matrices", "lin1999-n4", "-o", "out.mat"),
    "matrices .npz": ("matrices", "lin1999-n4", "-o", "out.npz"),
    "modes .nc": ("modes", "lin1999-n4", "-o", "out.nc"),
    "modulation .csv": ("modulation", "ren2021", "-o", "out.csv"),
    "new .toml": ("new", "--ratio", "5", "--power", "1 MW", "--speed", "1500 rpm", "--force", "out.toml"),
    "output .nc": ("output", "wind-stage", "--samples", "4", "-o", "out.nc"),
    "report .html": ("report", "lin1999-n3", "-o", "out.html"),
    "schema": ("schema", "-o", "out.json"),
    "sensitivity .nc": ("sensitivity", "lin1999-n4", "-o", "out.nc"),
    "sharing .nc": ("sharing", "ren2021", "--cycles", "2", "-o", "out.nc"),
    "show .html": ("show", "sources/saved.nc", "-o", "out.html"),
    "spectrum .toml": ("spectrum", "sources/history.csv", "--member", "main.carrier", "-o", "out.toml"),
    "stability .nc": ("stability", "ren2021", "--points", "20", "-o", "out.nc"),
    "static .html": ("static", "lin1999-n4", "--cycles", "1", "-o", "out.html"),
    "steady .nc": ("steady", "ren2021", "-o", "out.nc"),
    "stiffness .nc": ("stiffness", "ren2021", "-o", "out.nc"),
    "study --store": ("study", "sources/job.toml", "--store", "record", "-o", "out.nc"),
    "sweep .nc": ("sweep", "ren2021", "--points", "40", "-o", "out.nc"),
    "sweep --contact-loss": ("sweep", "ren2021", "--contact-loss", "--points", "4", "-o", "out.nc"),
    "tolerance --store": ("tolerance", "ren2021", "--samples", "65536", "--store", "record", "-o", "out.nc"),
    "track .nc": ("track", "lin1999-n4", "--over", "stages.main.sun.mass", "--points", "5", "-o", "out.nc"),
    "transient .nc": ("transient", "ren2021", "--cycles", "40", "-o", "out.nc"),
    "relief --resume": (
        *("relief", "ren2021", "--mesh", "sun-planet", "--vary", "tip_relief.amount=0..40 um"),
        *("--vary", "tip_relief.length=1..3 mm", "--population", "4", "--generations", "2", "--samples", "4"),
        *("--slices", "2", "--resume", "record", "-o", "out.toml"),
    ),
}
_BEFORE = b"what was there before"
_JOB = """verb = "modes"
model = "lin1999-n4"
keep = ["frequency"]
[grid]
"stages.main.sun.mass" = { from = "0.4 kg", to = "0.9 kg", points = 6 }
"""


@cache
def _sources() -> Path:
    """A folder with what commands read: a REXS file, a result, a load history, a job, bearings by their parts."""
    folder = Path(tempfile.mkdtemp())
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    epicyclic.write_rexs(epicyclic.load("wind-stage"), folder / "train.rexs")
    save_result(epicyclic.modes("lin1999-n4"), folder / "saved.nc")
    rows = "".join(f"{i},{1000 + 50 * (i % 7)},{12 + i % 3}\n" for i in range(200))
    (folder / "history.csv").write_text(f"time [s],torque [kN m],speed [rpm]\n{rows}", encoding="utf-8")
    (folder / "job.toml").write_text(_JOB, encoding="utf-8")
    page = (ROOT / "docs" / "how-to" / "life.md").read_text(encoding="utf-8")
    (folder / "parts.toml").write_text(page.split("```toml\n", 1)[1].split("```", 1)[0], encoding="utf-8")
    return folder


def _start(arguments: tuple[str, ...], folder: Path) -> subprocess.Popen[bytes]:
    given = [text.replace("sources/", f"{_sources()}/") for text in arguments]
    command = [sys.executable, "-m", "epicyclic", *given]
    return subprocess.Popen(command, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)


def _whole(path: Path) -> bool:
    """Whether a file is whole, by its kind."""
    raw = path.read_bytes()
    if raw == _BEFORE:
        return True
    try:
        match path.suffix:
            case ".nc":
                load_result(path)
            case ".json":
                json.loads(raw)
            case ".toml":
                tomllib.loads(raw.decode())
            case ".rexs":
                ElementTree.fromstring(raw)
            case ".xlsx":
                pd.read_excel(path)
            case ".npz":
                np.load(path)["M"]
            case ".mat":
                loadmat(path)["M"]
            case ".csv":
                return raw.endswith(b"\n")
            case _:
                return raw.rstrip().endswith(b"</html>")
    except (ValueError, KeyError, OSError, ElementTree.ParseError, BadZipFile):
        return False
    return True


def _prepared(folder: Path, arguments: tuple[str, ...]) -> Path:
    """The file a command writes, with something of the user's in it and beside it."""
    target = folder / arguments[-1]
    target.write_bytes(_BEFORE)
    (folder / f"{target.name}.part").write_bytes(b"mine")
    return target


def _again(arguments: tuple[str, ...], folder: Path) -> tuple[str, ...]:
    """The arguments of a command that goes on where another was killed."""
    kept = "record" if "--store" in arguments else f"{arguments[-1]}.parts"
    known = "--resume" in arguments or not (folder / kept).exists()
    return arguments if known else (*arguments, "--resume")


def kills(count: int, seed: int = 1) -> Counter[str]:
    """Commands killed at random times: whether the old file or the whole new one is there, and a next run works."""
    rng, found, lasts = random.Random(seed), Counter[str](), dict[str, float]()
    for number in range(count):
        name = list(COMMANDS)[number % len(COMMANDS)]
        arguments = COMMANDS[name]
        with tempfile.TemporaryDirectory() as made:
            folder = Path(made)
            target = _prepared(folder, arguments)
            if name not in lasts:
                began = time.perf_counter()
                _start(arguments, folder).communicate()
                lasts[name] = time.perf_counter() - began
                target.write_bytes(_BEFORE)
                shutil.rmtree(folder / "record", ignore_errors=True)
            running = _start(arguments, folder)
            try:  # most of what can be damaged is written near the end
                running.communicate(timeout=lasts[name] * rng.uniform(0.3, 1.1))
                found["ended before"] += 1
            except subprocess.TimeoutExpired:
                running.kill()
                running.communicate()
                found["killed"] += 1
            mine = (folder / f"{target.name}.part").read_bytes() == b"mine"
            records = [path for path in folder.glob("record/run.json") if not _whole(path)]
            found["damaged"] += not (_whole(target) and mine and not records)
            found["temporary files left"] += len([path for path in folder.rglob("*.part") if path.name.startswith(".")])
            again = _start(_again(arguments, folder), folder)
            said = again.communicate()[1]
            good = again.returncode == 0 and _whole(target) and target.read_bytes() != _BEFORE
            found["next run in trouble"] += not good
            if not good:
                print(name, again.returncode, said.decode()[-300:])
    return found


def races(count: int) -> Counter[str]:
    """Two commands that write the same file: whether it is whole, and each has written or says why not."""
    found = Counter[str]()
    for number in range(count):
        name = list(COMMANDS)[number % len(COMMANDS)]
        arguments = COMMANDS[name]
        with tempfile.TemporaryDirectory() as made:
            folder = Path(made)
            target = _prepared(folder, arguments)
            both = [_start(arguments, folder) for _ in range(2)]
            said = [one.communicate()[1].decode() for one in both]
            codes = sorted(one.returncode for one in both)
            found[f"status {codes[0]} and {codes[1]}"] += 1
            mine = (folder / f"{target.name}.part").read_bytes() == b"mine"
            whole = _whole(target) and target.read_bytes() != _BEFORE and mine
            found["damaged"] += not whole
            found["temporary files left"] += len([path for path in folder.rglob("*.part") if path.name.startswith(".")])
            found["folders left"] += (folder / f"{target.name}.parts").exists()
            if codes[1] not in (0, 2) or codes[0] != 0 or not whole:
                found["trouble"] += 1
                print(name, codes, *(text[-300:] for text in said))
    return found


def main() -> None:
    """Run one part from the command line."""
    part, count = sys.argv[1], int(sys.argv[2])
    seed = int(sys.argv[3]) if len(sys.argv) > 3 else 1
    began = time.perf_counter()
    if part == "mutations":
        found = mutations(count, seed)
    elif part == "kills":
        found = kills(count, seed)
    elif part == "races":
        found = races(count)
    else:
        with tempfile.TemporaryDirectory() as folder:
            found = damages(count, Path(folder), seed)
    for name, number in sorted(found.items()):
        print(f"{name}: {number}")
    print(f"{count} {part} in {time.perf_counter() - began:.0f} s")


if __name__ == "__main__":
    main()
