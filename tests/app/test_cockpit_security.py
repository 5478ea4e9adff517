"""The cockpit against other sites, other machines and hostile files, with the whole server in a process of its own."""

from __future__ import annotations

import base64
import re
import socket
import zlib
from pathlib import Path
from typing import Any

import pytest
from tests.app.cockpit_driver import Cockpit, Tab, still

pytestmark = pytest.mark.browser
MODEL = "lin1999-n3"  # nothing is looked at that takes long to compute


@pytest.fixture(scope="module")
def cookie(cockpit: Cockpit) -> str:
    answer = said(cockpit, request("GET", cockpit.address.removeprefix(cockpit.origin).partition("#")[0], cockpit.port))
    found = re.search(r"set-cookie: ([^;\r\n]+)", answer)
    assert found, answer
    return found[1]


@pytest.fixture(scope="module")
def folder(cockpit: Cockpit, cookie: str) -> str:
    """Where the scripts of the panes lie."""
    answer = said(cockpit, request("GET", "/", cockpit.port, f"Cookie: {cookie}"))
    found = re.search(r'"epicyclic-cockpit/": ?"([^"]+)/"', answer)
    assert found, answer
    return found[1]


def request(method: str, path: str, port: int, *headers: str, host: str = "", body: bytes = b"") -> bytes:
    """A request as it goes over the wire: no client tidies it up."""
    lines = [f"{method} {path} HTTP/1.1", f"Host: {host or f'127.0.0.1:{port}'}", *headers, "Connection: close", "", ""]
    return "\r\n".join(lines).encode("latin-1") + body


def said(cockpit: Cockpit, raw: bytes, address: str = "127.0.0.1") -> str:
    """What the server answers until it closes the connection."""
    with socket.create_connection((address, cockpit.port), timeout=10) as wire:
        wire.sendall(raw)
        found = b""
        try:
            while part := wire.recv(65536):
                found += part
        except (TimeoutError, ConnectionResetError):
            pass
    return found.decode("latin-1")


def status(answer: str) -> int:
    return int(answer.split(maxsplit=2)[1]) if answer else 0


UPGRADE = (
    "Upgrade: websocket",
    "Connection: Upgrade",
    "Sec-WebSocket-Version: 13",
    "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==",
)
SOCKET = "/_nicegui_ws/socket.io/?EIO=4&transport=websocket&client_id=x&next_message_id=0"


def shake(cockpit: Cockpit, *headers: str, host: str = "") -> int:
    """Status of the answer to a request for a websocket."""
    lines = [f"GET {SOCKET} HTTP/1.1", f"Host: {host or f'127.0.0.1:{cockpit.port}'}", *UPGRADE, *headers, "", ""]
    with socket.create_connection(("127.0.0.1", cockpit.port), timeout=10) as wire:
        wire.sendall("\r\n".join(lines).encode())
        return status(wire.recv(65536).decode("latin-1"))


def test_it_listens_on_this_machine_alone(cockpit: Cockpit) -> None:
    psutil = pytest.importorskip("psutil")
    listening = [
        one.laddr.ip
        for process in cockpit.processes()
        for one in process.net_connections(kind="inet")
        if one.status == psutil.CONN_LISTEN
    ]
    assert listening
    assert set(listening) == {"127.0.0.1"}
    others = [one.address for found in psutil.net_if_addrs().values() for one in found if one.family == socket.AF_INET]
    for address in {*others, "127.0.0.2"} - {"127.0.0.1"}:
        with pytest.raises(OSError, match=r"refused|unreachable|timed out"):
            said(cockpit, request("GET", "/", cockpit.port), address)


def test_a_name_that_points_here_is_refused(cockpit: Cockpit, cookie: str) -> None:
    own = f"Cookie: {cookie}"
    assert status(said(cockpit, request("GET", "/", cockpit.port, own))) == 200
    assert status(said(cockpit, request("GET", "/", cockpit.port, own, host=f"evil.example:{cockpit.port}"))) == 421
    assert shake(cockpit, own, f"Origin: {cockpit.origin}") == 101
    assert shake(cockpit, own, host=f"evil.example:{cockpit.port}") == 403
    assert shake(cockpit, own, "Origin: http://evil.example") == 403
    assert shake(cockpit, own, "Origin: http://127.0.0.1:1") == 403
    assert shake(cockpit) == 403  # no cookie


def test_polling_has_the_same_guard(cockpit: Cockpit, cookie: str) -> None:
    path = "/_nicegui_ws/socket.io/?EIO=4&transport=polling"
    own = f"Cookie: {cookie}"
    assert status(said(cockpit, request("GET", path, cockpit.port, own))) == 200
    assert status(said(cockpit, request("GET", path, cockpit.port))) == 403
    assert status(said(cockpit, request("GET", path, cockpit.port, own, "Origin: http://evil.example"))) == 403


def test_bodies_have_an_end(cockpit: Cockpit, cookie: str) -> None:
    own, path = f"Cookie: {cookie}", "/_nicegui/client/x/upload/1"
    chunked = request("POST", path, cockpit.port, own, "Transfer-Encoding: chunked", body=b"1\r\nx\r\n")
    assert status(said(cockpit, chunked)) == 411
    # refused by what it says, before any of it is sent
    assert status(said(cockpit, request("POST", path, cockpit.port, own, "Content-Length: 999999999999"))) == 413
    assert status(said(cockpit, request("POST", path, cockpit.port, own, "Content-Length: 4010001"))) == 413
    both = request(
        "POST", path, cockpit.port, own, "Content-Length: 1", "Transfer-Encoding: chunked", body=b"0\r\n\r\n"
    )
    assert status(said(cockpit, both)) in (400, 411)


@pytest.mark.parametrize(
    "path",
    [
        "/_nicegui/{v}/static/../../../../../etc/passwd",
        "/_nicegui/{v}/static/%2e%2e/%2e%2e/__init__.py",
        "/_nicegui/{v}/static/..%5c..%5c__init__.py",
        "{folder}/../element.py",
        "{folder}/%2e%2e/element.py",
        "{folder}/..%2felement.py",
        "/_nicegui/{v}/components/../../nicegui.py",
        "/_nicegui/{v}/resources/epicyclic-cockpit//etc/passwd",
        "/_nicegui/auto/static/x/../../../etc/passwd",
        "//etc/passwd",
        "/etc/passwd",
    ],
)
def test_no_path_leaves_the_folders_of_the_page(cockpit: Cockpit, cookie: str, folder: str, path: str) -> None:
    from nicegui import __version__

    written = path.format(v=__version__, folder=folder)
    answer = said(cockpit, request("GET", written, cockpit.port, f"Cookie: {cookie}"))
    assert status(answer) in (400, 403, 404), answer[:200]
    assert "root:" not in answer
    assert "from __future__" not in answer


def test_no_source_is_given_out(cockpit: Cockpit, cookie: str, folder: str) -> None:
    own = f"Cookie: {cookie}"
    assert status(said(cockpit, request("GET", f"{folder}/LICENSE-uPlot", cockpit.port, own))) == 200
    assert status(said(cockpit, request("GET", f"{folder}/LICENSE-uPlot", cockpit.port))) == 403
    assert status(said(cockpit, request("GET", f"{folder}/element.py", cockpit.port, own))) == 404


EVIL = '<img src=x onerror="window.hacked=1"><script>window.hacked=1</script>'


def hostile_model(folder: Path) -> Path:
    """A model whose title, names and file name say what a careless page would execute."""
    from epicyclic.cockpit.state.state import opened

    text = re.sub(r"^(title|notes) *=.*$", "", opened("ren2021").base, flags=re.MULTILINE)
    path = folder / f"{EVIL.replace('/', '-')}.toml"
    path.write_text(f"title = '''{EVIL}'''\nnotes = '''{EVIL}'''\n{text}", encoding="utf-8")
    return path


def test_hostile_titles_stay_text_in_every_view(cockpit: Cockpit, browser: Any) -> None:
    path = hostile_model(cockpit.folder)
    context = still(browser)
    tab = Tab(context, cockpit.address)
    rev = tab.rev
    tab.page.locator("input[type=file]").first.set_input_files(str(path))
    tab.painted(rev)
    looked = views(tab)
    assert len(looked) >= MOST_VIEWS, looked
    tab.page.reload()
    tab.painted()
    assert_text(tab, "after a reload")
    context.close()


# tabs of the evidence, folds of the levers, and the dialogs of the header: fewer would mean that some were not found
MOST_VIEWS = 10


def views(tab: Tab) -> list[str]:
    """Open everything that opens, and look at it; of what has one name but for its numbers, the first."""
    from playwright.sync_api import TimeoutError

    seen, kinds = [], set[str]()
    for role in ("tab", "button"):
        names = [one for one in tab.page.get_by_role(role).all() if one.is_visible()]
        for place in names:
            name = (place.get_attribute("aria-label") or place.inner_text()).strip()
            if re.search(r"Run|Cancel|Start|Save|Theme|Close|Copy|Undo|Redo|Compute", name) or not place.is_visible():
                continue
            if re.sub(r"\d+.*", "", name) in kinds:
                continue
            try:
                place.click(timeout=1500)
            except TimeoutError:  # of playwright: a view that fills the page lies over it
                continue
            tab.page.wait_for_timeout(300)  # [ms] what opens is drawn
            assert_text(tab, name)
            seen.append(name)
            kinds.add(re.sub(r"\d+.*", "", name))
            close(tab)
    return seen


def close(tab: Tab) -> None:
    """Close what is open, by the key."""
    for _ in range(20):
        tab.page.keyboard.press("Escape")
        tab.page.wait_for_timeout(100)  # [ms] a dialog fades
        if tab.page.locator(".q-dialog__backdrop, .q-menu").count() == 0:
            return


def assert_text(tab: Tab, where: str) -> None:
    assert tab.page.evaluate("window.hacked") is None, where
    assert tab.page.locator("img[src=x]").count() == 0, where
    assert tab.errors() == [], where


def test_a_model_of_others_names_no_file(cockpit: Cockpit, browser: Any, tmp_path: Path) -> None:
    from epicyclic.cockpit.state.state import opened

    (tmp_path / "box.csv").write_text("1\n" * 23)
    context = still(browser)
    tab = Tab(context, cockpit.address)
    rev = tab.rev
    for place, name in enumerate(("/etc/passwd", "../../../etc/passwd", "box.csv")):
        path = tmp_path / f"box{place}.toml"
        path.write_text(opened("ren2021").base.replace('sun.run_out     = "20 um"', f"sun.pitch = '{name}'"), "utf-8")
        tab.page.locator("input[type=file]").first.set_input_files(str(path))
        said = tab.page.locator("[role=alert]").filter(has_text=f"{path.name} cannot be opened")
        said.filter(has_text="a model of this page may name no file").first.wait_for()
        assert tab.rev == rev
    context.close()


def fragment(text: bytes) -> str:
    return base64.urlsafe_b64encode(zlib.compress(text, 9)).decode().rstrip("=")


# more of them, without a browser, in the tests of links; here one of each kind of refusal
HOSTILE_LINKS = {
    "a bomb": fragment(b"0" * 20_000_000),
    "a script": "<img src=x onerror=window.hacked=1>",
    "a file": fragment(b'{"name": "x", "base": "[deviations]\\nsun.pitch = \'/etc/passwd\'", "overrides": []}'),
    "longer than a message may be": "A" * 1_500_000,
}


def test_links_of_others_do_no_harm(cockpit: Cockpit, browser: Any) -> None:
    context = still(browser)
    tab = Tab(context, cockpit.address)
    for name, text in HOSTILE_LINKS.items():
        with tab.page.expect_event("load"):
            tab.page.evaluate("text => { location.hash = text; }", text)
        tab.page.get_by_text("The link cannot be opened").wait_for()
        assert tab.page.evaluate("window.hacked") is None, name
        tab.painted()  # what the tab had stands there instead
    context.close()
    quick = Tab(still(browser), cockpit.address)  # the server is as before
    assert quick.rev >= 0
    quick.page.close()
