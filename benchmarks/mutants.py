"""Mutants: small wrong changes of the package, and whether the tests see them.

    python benchmarks/mutants.py [--formerly] [--only TEXT] [-o results.json] [--root FOLDER] [--unchecked]

Works on a copy of a checkout in a temporary folder, this one or that of --root.  Each mutant of `mutants.toml` is put
in, its tests run, and it is taken out again.  Mutants whose sentence holds TEXT run alone.  With --formerly texts and
tests are those of a checkout before its modules moved.  First all tests must pass without a mutant; --unchecked trusts
that they do.

[[mutant]]
part = "engine" or "desk".  what : sentence, what is wrong then.  tests : files or ids of tests that should see it.
old : text that stands in one place of the package alone, with any common indentation.  new : takes its place.
formerly = {old, new, tests} : what of these was another one before.

Results are written after each mutant; one that stands in the file of results already is not run again.  Exit status 1
where a mutant survived or does not apply, 2 where a test fails without one.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import textwrap
import time
import tomllib
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
SUFFIXES = (".py", ".js")
SECONDS = 300.0  # for the tests of a mutant: one that never ends is seen too
_FAILED = re.compile(r"^(?:FAILED|ERROR) (.+?)(?: - .*)?$", re.MULTILINE)


def mutants(*, formerly: bool) -> list[dict[str, Any]]:
    """What `mutants.toml` holds, as it is now or as it was."""
    table = tomllib.loads(ROOT.joinpath("benchmarks", "mutants.toml").read_text(encoding="utf-8"))
    found = [(mutant, mutant.pop("formerly", {})) for mutant in table["mutant"]]
    return [mutant | (before if formerly else {}) for mutant, before in found]


def copied(root: Path, folder: Path) -> None:
    """A copy of the checkout, with the times of its files: what is compiled stays."""
    for name in ("src", "tests", "benchmarks", "docs", "examples"):
        shutil.copytree(root / name, folder / name)
    for path in root.iterdir():
        if path.is_file():
            shutil.copy2(path, folder)


def changed(package: Path, old: str, new: str) -> list[tuple[Path, str]]:
    """The files in which the text stands, as often as it does, each with what it is with the new text."""
    before, after = (textwrap.dedent(text).strip("\n").split("\n") for text in (old, new))
    wanted = re.compile(r"(?m)(?P<indent>^[ \t]*)?" + r"\n(?P=indent)".join(map(re.escape, before)))
    found = []
    for path in sorted(path for path in package.rglob("*") if path.suffix in SUFFIXES):
        text = path.read_text(encoding="utf-8")
        for match in wanted.finditer(text):
            indent = match["indent"] or ""
            lines = indent + f"\n{indent}".join(after)
            found.append((path, text[: match.start()] + lines + text[match.end() :]))
    return found


def run(folder: Path, tests: Sequence[str], limit: float | None = None) -> tuple[int, str]:
    """Exit status of the tests, and what they print; they are ended after a time [s], which is status 1."""
    path = os.pathsep.join(str(folder / name) for name in ("src", "benchmarks"))
    environment = os.environ | {"PYTHONPATH": path, "PYTHONDONTWRITEBYTECODE": "1", "COLUMNS": "400"}
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", *tests]
    options: dict[str, Any] = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
    with subprocess.Popen(command, cwd=folder, env=environment, start_new_session=True, **options) as process:
        try:
            printed, _ = process.communicate(timeout=limit)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            return 1, f"FAILED time-limit\n{process.communicate()[0]}"
    return process.returncode, printed


def outcome(folder: Path, mutant: dict[str, Any]) -> tuple[str, str]:
    """Killed, survived or not applicable, and by which test or why."""
    places = changed(folder / "src" / "epicyclic", mutant["old"], mutant["new"])
    if len(places) != 1:
        return "not applicable", f"its text stands in {len(places)} places"
    (path, text), before, times = places[0], places[0][0].read_bytes(), places[0][0].stat()
    try:
        path.write_text(text, encoding="utf-8", newline="")
        status, printed = run(folder, mutant["tests"], SECONDS)
    finally:
        path.write_bytes(before)
        os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))
    if status not in (0, 1, 2):
        raise SystemExit(f"{mutant['what']}\n{printed}")
    failed = _FAILED.search(printed)
    return ("SURVIVED", "") if status == 0 else ("killed", failed[1] if failed else "(no test could run)")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--formerly", action="store_true")
    parser.add_argument("--only", default="", metavar="TEXT")
    parser.add_argument("--root", type=Path, default=ROOT, metavar="FOLDER")
    parser.add_argument("--unchecked", action="store_true")
    parser.add_argument("-o", dest="output", type=Path, metavar="FILE")
    chosen = parser.parse_args()
    kept: Path | None = chosen.output
    every = mutants(formerly=chosen.formerly)
    results = json.loads(kept.read_text(encoding="utf-8")) if kept is not None and kept.exists() else []
    results = [result for result in results if result["mutant"] in every]
    known = [result["mutant"] for result in results]
    todo = [mutant for mutant in every if mutant not in known and chosen.only in mutant["what"]]
    with tempfile.TemporaryDirectory() as name:
        copied(chosen.root, Path(name))
        if todo and not chosen.unchecked:
            status, printed = run(Path(name), sorted({test for mutant in todo for test in mutant["tests"]}))
            if status:
                print(printed)
                return 2
        for number, mutant in enumerate(todo, 1):
            begun = time.monotonic()
            word, by = outcome(Path(name), mutant)
            results.append({"mutant": mutant, "outcome": word, "by": by, "seconds": time.monotonic() - begun})
            print(f"{number:3}/{len(todo)} {word:8} {mutant['what']}  {by}", flush=True)
            if kept is not None:
                kept.write_text(json.dumps(results, indent=1, ensure_ascii=False), encoding="utf-8")
    count = Counter(result["outcome"] for result in results)
    print(", ".join(f"{number} {word}" for word, number in count.items()))
    return int(count["killed"] < len(results))


if __name__ == "__main__":
    sys.exit(main())
