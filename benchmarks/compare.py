"""Every verb over many drives in two checkouts, number by number: what a change of the code must not move.

    python benchmarks/compare.py OLD NEW [--verbs modes,sweep] [--drives ren2021,own/links] [--jobs 2] [-o table.md]
        [--keep DIR] [--rounding Nehalem]

Each checkout runs in processes of its own, with PYTHONPATH=CHECKOUT/src and one thread of the linear algebra; model
files of the tests come from OLD, for both.  `compare_cases` says what is run, `compare_measures` how differences are
measured and what is allowed.  An error is a result too: its type and its path are compared.  Warnings are counted;
other wording of messages and long names is told, and is no difference.

Results are kept in ``--keep DIR``, a folder for each state of a checkout: its commit and a hash of the names and bytes
of all files below src, __pycache__ left out.  A file in it is named by a hash of the task, that is of verb, options and
text of the model, of the interpreter and libraries, and of the code that runs it.  What is there is not run again; old
and new have folders of their own, so that one state against itself is computed twice.

Some results hang on the last bit: a branch begun or not, the direction of a force that symmetry makes zero, which of
two equal paths is ranked first.  Code that only sums in another order moves them.  ``--rounding KERNEL`` runs OLD once
more with another kernel of OpenBLAS (Nehalem, Haswell, ...) and makes a note of what that moves too, to a thirtieth of
the difference at least; without it nothing is let through.

Exit status 1 where something moved.
"""

from __future__ import annotations

import argparse
import ast
import contextlib
import hashlib
import json
import os
import pickle
import queue
import select
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from compare_cases import CASES, Task, drives_of, tasks_of
from compare_measures import Finding, compared, excused
from compare_table import Row, failures, notes, page, summary

__all__ = ["Checkout", "Job", "main", "run_all"]

_WORKER = Path(__file__).with_name("compare_worker.py")
_START = 120.0  # seconds to import the package
Record = dict[str, Any]


@dataclass(frozen=True, slots=True, kw_only=True)
class Checkout:
    """A source tree: how it is named, where it is, the folder of its results, and a kernel of OpenBLAS, "" for any."""

    name: str
    root: Path
    python: str
    folder: Path
    versions: Mapping[str, str]
    kernel: str = ""

    def target(self, task: Task) -> Path:
        """Where the result of a task is kept."""
        files = [Path(value) for value in task.options.values() if isinstance(value, str) and value.endswith(".csv")]
        asked = repr({key: value for key, value in task.options.items() if Path(str(value)) not in files})
        read = [file.read_text("utf-8") for file in (*files, _WORKER)]
        said = [task.verb, task.drive, task.text, asked, self._libraries(), *read]
        return self.folder / f"{hashlib.sha256(json.dumps(said).encode()).hexdigest()[:20]}.pkl"

    def _libraries(self) -> str:
        return json.dumps({key: value for key, value in self.versions.items() if key != "package"}, sort_keys=True)


@dataclass(frozen=True, slots=True, kw_only=True)
class Job:
    """One task in one checkout."""

    checkout: Checkout
    task: Task


class Worker:
    """A process that runs tasks one after another; started again after a crash or when time is up."""

    def __init__(self, root: Path, python: str, kernel: str = "") -> None:
        src = str(root / "src")
        environment = os.environ | {"PYTHONPATH": src, "OPENBLAS_NUM_THREADS": "1", "PYTHONHASHSEED": "0"}
        if kernel:
            environment["OPENBLAS_CORETYPE"] = kernel
        self._told = tempfile.TemporaryFile()
        self._process = subprocess.Popen(
            [python, str(_WORKER)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._told,
            env=environment,
            cwd=tempfile.gettempdir(),
        )
        self.versions: dict[str, str] = {}
        try:
            self.versions = ast.literal_eval(self._answer(_START))
            if not Path(self.versions["package"]).is_relative_to((root / "src").resolve()):
                raise RuntimeError(f"{src} is not what is imported, {self.versions['package']} is")
        except (EOFError, TimeoutError, RuntimeError):
            self.close()
            raise

    def _answer(self, seconds: float) -> str:
        """The next line; EOFError where the process ended, TimeoutError where none came."""
        pipe = self._process.stdout
        assert pipe is not None
        if not select.select([pipe], [], [], seconds)[0]:
            raise TimeoutError(f"no answer in {seconds:g} s")
        line = pipe.readline()
        if not line:
            raise EOFError(f"the process ended with status {self._process.wait()}: {self._last_words()}")
        return line.decode("utf-8")

    def _last_words(self) -> str:
        self._told.seek(0)
        return self._told.read()[-400:].decode("utf-8", "replace").strip()

    def run(self, task: Task, target: Path, seconds: float) -> None:
        """Run one task, its record at `target`."""
        pipe = self._process.stdin
        assert pipe is not None
        try:
            pipe.write((repr((task.verb, task.source, task.options, str(target))) + "\n").encode())
            pipe.flush()
        except BrokenPipeError:
            raise EOFError(f"the process is gone: {self._last_words()}") from None
        self._answer(seconds)

    def close(self) -> None:
        """End the process."""
        self._process.kill()
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout, self._told):
            if pipe is not None:
                with contextlib.suppress(BrokenPipeError):
                    pipe.close()


def run_all(jobs: Sequence[Job], *, workers: int, seconds: float, told: Callable[[Job, Record], None]) -> None:
    """Run jobs in so many processes; `told` is given every record, one at a time."""
    waiting: queue.SimpleQueue[Job] = queue.SimpleQueue()
    for job in jobs:
        waiting.put(job)
    lock = threading.Lock()

    def serve() -> None:
        worker: Worker | None = None
        at: Checkout | None = None
        while True:
            try:
                job = waiting.get_nowait()
            except queue.Empty:
                break
            if worker is not None and at != job.checkout:
                worker.close()
                worker = None
            worker, record = _served(worker, job, seconds)
            at = job.checkout
            with lock:
                told(job, record)
        if worker is not None:
            worker.close()

    threads = [threading.Thread(target=serve) for _ in range(max(1, min(workers, len(jobs))))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()


def _served(worker: Worker | None, job: Job, seconds: float) -> tuple[Worker | None, Record]:
    """The record of a job, and the worker that goes on, None where it is done with."""
    begin = time.perf_counter()
    target = job.checkout.target(job.task)
    try:
        worker = worker or Worker(job.checkout.root, job.checkout.python, job.checkout.kernel)
        worker.run(job.task, target, seconds)
        return worker, pickle.loads(target.read_bytes())
    except (EOFError, TimeoutError, RuntimeError, OSError) as error:
        if worker is not None:
            worker.close()
        outcome = "timeout" if isinstance(error, TimeoutError) else "crash"
        return None, {"outcome": outcome, "message": str(error), "seconds": time.perf_counter() - begin, "caught": []}


def _versions(root: Path, python: str) -> dict[str, str]:
    """What the interpreter computes with."""
    worker = Worker(root, python)
    worker.close()
    return worker.versions


def _checkout(name: str, root: Path, python: str, keep: Path, versions: Mapping[str, str]) -> Checkout:
    """A checkout with its folder, which is made."""
    folder = keep / name / _state(root)
    folder.mkdir(parents=True, exist_ok=True)
    return Checkout(name=name, root=root, python=python, folder=folder, versions=versions)


def _state(root: Path) -> str:
    """Commit and content of src."""
    said = subprocess.run(["git", "-C", str(root), "rev-parse", "HEAD"], capture_output=True, text=True, check=False)
    commit = said.stdout.strip()[:12] or "no-commit"
    content = hashlib.sha256()
    for path in sorted((root / "src").rglob("*")):
        if path.is_file() and "__pycache__" not in path.parts and ".egg-info" not in str(path):
            content.update(f"{path.relative_to(root)}\0".encode() + hashlib.sha256(path.read_bytes()).digest())
    return f"{commit}-{content.hexdigest()[:12]}"


def _records(
    checkouts: Sequence[Checkout], tasks: Sequence[Task], *, workers: int, seconds: float
) -> dict[tuple[str, str], Record]:
    """(checkout, task) -> record, from the folder where it is there."""
    records: dict[tuple[str, str], Record] = {}
    jobs: list[Job] = []
    for checkout in checkouts:
        for task in tasks:
            target = checkout.target(task)
            if target.is_file():
                records[checkout.name, task.name] = pickle.loads(target.read_bytes())
            else:
                jobs.append(Job(checkout=checkout, task=task))
    done = 0

    def told(job: Job, record: Record) -> None:
        nonlocal done
        done += 1
        records[job.checkout.name, job.task.name] = record
        if sys.stderr.isatty() or done % 50 == 0 or record["seconds"] > 20:
            line = f"{done}/{len(jobs)} {job.checkout.name}: {job.task.name}, {record['seconds']:.1f} s"
            print(line, file=sys.stderr, flush=True)

    run_all(jobs, workers=workers, seconds=seconds, told=told)
    return records


def _rows(tasks: Sequence[Task], records: Mapping[tuple[str, str], Record]) -> list[Row]:
    """Every task compared; with records of ``rounding`` what it moves too is let through."""
    rows = []
    for task in tasks:
        old, new = records["old", task.name], records["new", task.name]
        try:
            found = compared(old, new, task.tolerance)
            if found.failures and ("rounding", task.name) in records:
                found = excused(found, compared(old, records["rounding", task.name], task.tolerance))
        except Exception as error:  # one comparison that fails is a row, not the end
            found = Finding()
            found.fail("not comparable", f"{type(error).__name__}: {error}")
        outcome = old["type"] if old["outcome"] == "error" else old["outcome"]
        seconds = float(old["seconds"]), float(new["seconds"])
        rows.append(Row(case=task.case, drive=task.drive, outcome=outcome, found=found, seconds=seconds))
    return rows


def _listed(text: str | None) -> list[str] | None:
    return None if text is None else [entry.strip() for entry in text.split(",") if entry.strip()]


def _arguments(given: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("old", type=Path, help="checkout whose numbers stand")
    parser.add_argument("new", type=Path, help="checkout that must give the same")
    parser.add_argument("--verbs", help=f"verbs, or rows of the table: {','.join(case.name for case in CASES)}")
    parser.add_argument("--drives", help="drives, ren2021,good/parallel,own/links; own/ means all of a kind")
    parser.add_argument("--jobs", type=int, default=2, help="processes at a time")
    parser.add_argument("--timeout", type=float, default=300.0, help="seconds for one verb of one drive")
    parser.add_argument("--python", default=sys.executable, help="interpreter that runs both")
    parser.add_argument("--rounding", metavar="KERNEL", help="let through what another kernel of OpenBLAS moves in OLD")
    parser.add_argument("--keep", type=Path, help="folder of results, so that OLD is run once")
    parser.add_argument("-o", "--output", type=Path, help="file for the whole table, in Markdown")
    return parser.parse_args(given)


def _tasks(arguments: argparse.Namespace) -> list[Task]:
    """The tasks asked for."""
    verbs = _listed(arguments.verbs)
    drives, wanted = drives_of(arguments.old.resolve()), _listed(arguments.drives)
    if wanted is not None:
        drives = [
            drive
            for drive in drives
            if any(drive.name in (entry, f"ready/{entry}") or drive.name.startswith(entry) for entry in wanted)
        ]
    tasks = tasks_of(drives, verbs=verbs)
    if not tasks:
        raise SystemExit("nothing to run: no such verb or drive")
    return tasks


def main(given: Sequence[str] | None = None) -> int:
    """Run, compare, print; the exit status."""
    arguments = _arguments(given)
    begin = time.perf_counter()
    tasks = _tasks(arguments)
    with tempfile.TemporaryDirectory() as scratch:
        keep = (arguments.keep or Path(scratch)).resolve()
        roots = {"old": arguments.old.resolve(), "new": arguments.new.resolve()}
        for root in roots.values():
            if not (root / "src" / "epicyclic").is_dir():
                raise SystemExit(f"{root}: no checkout, src/epicyclic is not there")
        versions = _versions(roots["old"], arguments.python)
        old, new = (_checkout(name, root, arguments.python, keep, versions) for name, root in roots.items())
        checkouts = [old, new]
        if arguments.rounding:
            folder = keep / f"rounding-{arguments.rounding}" / old.folder.name
            folder.mkdir(parents=True, exist_ok=True)
            checkouts.append(replace(old, name="rounding", folder=folder, kernel=arguments.rounding))
        records = _records(checkouts, tasks, workers=arguments.jobs, seconds=arguments.timeout)
    rows = _rows(tasks, records)
    wall = time.perf_counter() - begin
    heads = {"old": old.folder.name, "new": new.folder.name}
    print(summary(rows))
    print(failures(rows, most=60))
    if arguments.output:
        arguments.output.write_text(page(rows, heads, wall), encoding="utf-8")
    else:
        print(notes(rows, most=20))
    failed = sum(row.failed for row in rows)
    spent = [
        sum(record.get("cpu_seconds", 0.0) for (at, _), record in records.items() if at == name)
        for name in ("old", "new")
    ]
    told = f"{len(rows)} results, {failed} moved; {wall:.0f} s, CPU of old {spent[0]:.0f} s, of new {spent[1]:.0f} s"
    print(f"{'FAIL' if failed else 'PASS'}: {told}")
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
