"""What commands print, against the part of the golden set that the repository holds (`benchmarks/golden.py`)."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
GOLDEN = ROOT / "benchmarks/golden.py"


COMMANDS = "check,modes,static,explain-K_gamma,no-such-command,no-such-path,wrong-unit,not-in-balance"


def test_words_and_numbers_are_those_that_are_kept(tmp_path: Path) -> None:
    options = ("--drives", "ren2021,desk", "--only", COMMANDS, "--jobs", "2")
    subprocess.run([sys.executable, str(GOLDEN), "collect", str(ROOT), str(tmp_path), *options], check=True)
    run = subprocess.run([sys.executable, str(GOLDEN), "check", str(tmp_path)], capture_output=True, text=True)
    *changed, compared = run.stdout.splitlines()
    assert changed == [], "what changed on purpose is kept anew by golden.py keep"
    assert int(compared.split()[0]) >= 12
