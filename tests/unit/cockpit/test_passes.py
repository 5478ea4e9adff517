"""The key of the user lies where nobody else reads it, and gives the same cookie to the next run on the same port."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from epicyclic.cockpit.server import issue, state_folder


def test_the_key_is_private_and_outlives_a_run(tmp_path: Path) -> None:
    first, second = issue(8765, tmp_path / "deep" / "state"), issue(8765, tmp_path / "deep" / "state")
    file = tmp_path / "deep" / "state" / "cockpit.key"
    assert file.stat().st_mode & 0o777 == 0o600
    assert first.cookie == second.cookie
    assert first.seal == second.seal != b""
    assert first.token != second.token  # an address of a former run gives no cookie
    assert first.cookie != issue(8766, tmp_path / "deep" / "state").cookie
    assert first.cookie != issue(8765, tmp_path / "other").cookie


@pytest.mark.parametrize("spoilt", ["readable", "short", "link", "folder"])
def test_a_key_that_others_may_know_is_not_used(tmp_path: Path, spoilt: str) -> None:
    before = issue(8765, tmp_path).cookie
    file = tmp_path / "cockpit.key"
    raw = file.read_bytes()
    if spoilt == "readable":
        file.chmod(0o644)
    elif spoilt == "short":
        file.write_bytes(raw[:-1])
    else:
        file.unlink()
        (tmp_path / "elsewhere").write_bytes(raw)
        (tmp_path / "elsewhere").chmod(0o600)
        if spoilt == "link":
            file.symlink_to(tmp_path / "elsewhere")
        else:
            file.mkdir()
    assert issue(8765, tmp_path).cookie != before
    if spoilt != "folder":
        assert file.stat().st_mode & 0o777 == 0o600
        assert not file.is_symlink()


def test_without_a_folder_the_key_is_of_the_run(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("no folder")
    assert issue(8765, None).cookie != issue(8765, None).cookie
    assert issue(8765, tmp_path / "file").cookie != issue(8765, tmp_path / "file").cookie


def test_the_folder_of_the_user(tmp_path: Path) -> None:
    assert state_folder({"XDG_STATE_HOME": str(tmp_path)}) == tmp_path / "epicyclic"
    assert state_folder({"LOCALAPPDATA": str(tmp_path)}, "win32") == tmp_path / "epicyclic"
    assert state_folder({}, "win32") is None
    home = Path(os.path.expanduser("~"))
    assert state_folder({}, "linux") == home / ".local" / "state" / "epicyclic"
    assert state_folder({}, "darwin") == home / "Library" / "Application Support" / "epicyclic"


def test_passes_admit_their_own_alone(tmp_path: Path) -> None:
    passes = issue(8765, tmp_path)
    name, value = passes.cookie
    assert passes.admits_token(passes.token)
    assert passes.admits_cookies(f"a=b; {name}={value}")
    assert passes.admits_cookies(
        f'list={{"a": [1]}}; b[]=<>; ={name}; {name}={value}'
    )  # of other programs of this host
    for header in ("", name, f"{name}=", f"{name}={value}x", f"{name}={value[:-1]}", f"x{name}={value}", f"{name}=ä"):
        assert not passes.admits_cookies(header)
    for token in ("", "ä", passes.token[:-1]):
        assert not passes.admits_token(token)
