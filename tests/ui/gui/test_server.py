"""Page and sockets of `cdpr gui`: access control, data for windows, and their requests."""

from __future__ import annotations

import re
import signal
import socket
import subprocess
import sys
import time
from contextlib import ExitStack
from urllib.error import HTTPError
from urllib.request import Request, urlopen

import pytest
from click.testing import CliRunner
from conftest import ROOT
from driver_cases import PATIENCE, QUIET, FakeWindow, wait
from spread import sampled

pytest.importorskip("websockets")

from websockets.exceptions import ConnectionClosedError, InvalidStatus
from websockets.sync.client import connect

from cdpr.base.errors import CdprError
from cdpr.ui.cli import cli
from cdpr.ui.cli.gui import _hold
from cdpr.ui.cli.progress import Signals
from cdpr.ui.gui.broadcast import Broadcast
from cdpr.ui.gui.editor import Editor
from cdpr.ui.gui.server import MOST_BYTES, MOST_WINDOWS, Server
from cdpr.ui.gui.window import Window

CAROCA = str(ROOT / "scenarios" / "caroca.yaml")
CHANGES = [("simulation.duration", QUIET["simulation.duration"])]


@pytest.fixture(scope="module")
def window():
    log = []
    with Window(Editor(CAROCA, [f"{key}={value}" for key, value in CHANGES]), log.append, port=0) as made:
        made.begin()
        wait(made._broadcast, "status", lambda status: status["phase"] == "ready")
        yield made
    assert log == []


def look(window, **options):
    return connect(socket_of(window), max_size=None, **options)


def socket_of(window):
    return window.address.replace("http:", "ws:")


@pytest.fixture
def looker(window):
    with look(window) as opened:
        found = FakeWindow(opened)
        found.send(do="reset")
        found.get("status", lambda status: status["phase"] == "ready" and status["t"] == 0.0)
        yield found


def test_a_window_is_sent_all_that_there_is(window):
    with look(window) as opened:
        found = FakeWindow(opened)
        found.get("frame")
        found.get("samples")
        kinds = [message["kind"] for message in found.seen]
        order = [kinds.index(kind) for kind in ("hello", "form", "scene", "status", "frame", "samples")]
        assert order == sorted(order)
        form = found.seen[kinds.index("form")]
        assert form["tabs"]
        assert form["applied"]


def test_two_windows_show_the_same(window, looker):
    with look(window) as opened:
        other = FakeWindow(opened)
        looker.send(do="speed", value=None)
        looker.send(do="push", force=[10, 0, 0], duration=0.1)
        looker.send(do="run")
        seen = []
        for each in (looker, other):
            done = each.get("status", lambda status: status["phase"] == "done")
            assert [event["t"] for event in done["events"]] == [0.0]
            seen.append(each.get("frame", lambda frame: frame["n"] == 300))
        assert seen[0] == seen[1]
    with look(window) as opened:  # and one that joins after the end
        late, times = FakeWindow(opened), []
        while len(times) < 301:
            times += late.get("samples")["t"]
        assert times == pytest.approx([0.001 * k for k in range(301)])


def test_a_form_is_edited_applied_and_undone(looker):
    looker.send(do="edit", path="robot.platform.mass", value=-5)
    form = looker.get("form", lambda form: form["undo"])
    assert any("mass" in problem["path"] for problem in form["problems"])
    looker.send(do="apply")
    text = looker.get("message")["text"]
    assert text.startswith("not applied: ")
    assert "mass" in text
    looker.send(do="undo")
    looker.send(do="edit", path="simulation.duration", value=0.2)
    assert not looker.get("form", lambda form: not form["problems"] and not form["redo"])["applied"]
    looker.send(do="apply")
    assert looker.get("form", lambda form: form["applied"])
    assert looker.get("scene")["duration"] == pytest.approx(0.2)
    looker.send(do="undo")
    looker.send(do="apply")
    assert looker.get("scene", lambda scene: scene["duration"] > 0.25)
    looker.send(do="yaml")
    assert "caroca" in looker.get("yaml")["files"][0]["text"]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("{", "expected JSON"),
        ("[" * 100_000, "expected JSON"),
        ("[]", "expected an object"),
        ('{"do": 1}', "expected an object"),
        ('{"do": "run", "fast": NaN}', "expected JSON"),
        ('{"do": "step", "n": 1e400}', "whole number"),
        ('{"do": "__init__"}', "not an allowed request"),
        ('{"do": "edit"}', "missing"),
        ('{"do": "edit", "path": 3, "value": 1}', "a key such as"),
        ('{"do": "edit", "path": "../../etc", "value": 1}', "a key such as"),
        ('{"do": "open", "name": "nowhere.yaml"}', "nowhere.yaml"),
        ('{"do": "new", "kind": "spaceship"}', "spaceship"),
        (b"\xff\xfe", "expected JSON"),
    ],
)
def test_invalid_requests_get_one_message(window, text, says):
    with look(window) as opened:
        opened.send(text)
        told = FakeWindow(opened).get("message")
    assert told["level"] == "error"
    assert re.search(says, told["text"]), told
    assert "Traceback" not in told["text"]
    assert "internal error" not in told["text"]


@pytest.mark.slow
def test_oversized_messages_close_only_their_window(window, looker):
    with look(window) as other:
        other.send("x" * (MOST_BYTES + 1))
        with pytest.raises(ConnectionClosedError, match="1009"):
            FakeWindow(other).get("nothing")
    looker.send(do="pause")
    looker.get("status")


def status_of(address, **headers):
    try:
        with urlopen(Request(address, headers=headers), timeout=PATIENCE) as answer:
            return answer.status, answer.headers, answer.read().decode()
    except HTTPError as error:
        return error.code, error.headers, error.read().decode()


def test_the_page_makes_no_other_requests(window):
    status, headers, text = status_of(window.address)
    assert status == 200
    assert text.startswith("<!DOCTYPE html>")
    assert "default-src 'none'" in headers["Content-Security-Policy"]
    assert "frame-ancestors 'none'" in headers["Content-Security-Policy"]
    assert headers["Referrer-Policy"] == "no-referrer"
    assert not re.search(r"""(src|href)=["']?(https?:)?//""", text)


def test_admitted_clients(window):
    address, port = window.address, window.address.split(":")[2].split("/")[0]
    assert status_of(address.partition("?")[0])[0] == 403
    assert status_of(address + "x")[0] == 403
    assert status_of(address.replace("/?", "/other?"))[0] == 404
    assert status_of(address, Host=f"evil.example:{port}")[0] == 421
    assert status_of(address, Host="[")[0] == 421
    assert status_of(address, Host=f"localhost:{port}")[0] == 200
    with pytest.raises(InvalidStatus, match="421"), look(window, additional_headers={"Host": "evil.example"}):
        pass  # it names two of them
    for origin in ("http://evil.example", "null", f"https://127.0.0.1:{port}"):
        with pytest.raises(InvalidStatus, match="403"), look(window, origin=origin):
            pass
    with look(window, origin=f"http://127.0.0.1:{port}"):
        pass
    with pytest.raises(InvalidStatus, match="403"), connect(socket_of(window)[:-1]):
        pass


def test_windows_are_so_many_at_most(window):
    with ExitStack() as opened:
        for _ in range(MOST_WINDOWS):
            FakeWindow(opened.enter_context(look(window))).get("hello")
        with pytest.raises(InvalidStatus, match="503"), look(window):
            pass
    end = time.monotonic() + PATIENCE
    while window._server._server._open and time.monotonic() < end:
        time.sleep(0.01)
    with look(window):
        pass


def served(**options):
    return Server(lambda: "page", Broadcast(), lambda words, reader: None, **options)


def test_the_printed_port_is_the_real_one():
    first = served(port=0)
    try:
        assert f":{first.port}/" in first.address
        with pytest.raises(
            CdprError, match=rf"127\.0\.0\.1, port {first.port}: Address already in use; leave out --port"
        ):
            served(port=first.port)
    finally:
        first.close()
    with socket.create_server(("127.0.0.1", 0)) as taken, pytest.MonkeyPatch.context() as patch:
        patch.setattr("cdpr.ui.gui.server.PORTS", [taken.getsockname()[1]])
        other = served()
        assert other.port != taken.getsockname()[1]
        other.close()
    with pytest.raises(CdprError, match=r"no\.such\.host"):
        served(host="no.such.host.invalid")


@pytest.mark.skipif(not socket.has_dualstack_ipv6(), reason="this machine has no IPv6 beside IPv4")
def test_everywhere_means_old_addresses_too():
    server = served(host="::", port=0)
    try:
        for host in ("127.0.0.1", "[::1]"):
            assert status_of(f"http://{host}:{server.port}/?{server.address.partition('?')[2]}")[0] == 200
    finally:
        server.close()


@pytest.mark.slow
def test_a_stalled_window_does_not_slow_others_or_the_exit():
    broadcast = Broadcast()
    server = Server(lambda: "page", broadcast, lambda words, reader: None, port=0)
    host, port = "127.0.0.1", server.port
    stuck = socket.create_connection((host, port))
    stuck.sendall(
        f"GET /?{server.address.partition('?')[2]} HTTP/1.1\r\nHost: {host}:{port}\r\n"
        "Connection: Upgrade\r\nUpgrade: websocket\r\n"
        "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: MDEyMzQ1Njc4OWFiY2RlZg==\r\n\r\n".encode()
    )
    with connect(server.address.replace("http:", "ws:")) as other:
        for n in range(300):  # 30 MB, more than any socket holds: what waited for this reader would never end
            broadcast.put({"kind": "frame", "n": n, "fat": "x" * 100_000})
        FakeWindow(other).get("frame", lambda frame: frame["n"] == 299)
    server.close()
    assert not server._server._threads
    stuck.close()


@pytest.mark.slow
@sampled(1, "number", [signal.SIGINT, signal.SIGTERM])
def test_the_command_stops_on_signals(number):
    command = [sys.executable, "-m", "cdpr", "gui", CAROCA, "--no-open", "--port", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        address = process.stdout.readline().strip()
        with connect(address.replace("http:", "ws:"), max_size=None, open_timeout=PATIENCE) as opened:
            FakeWindow(opened).get("hello")
            process.send_signal(number)
            out, err = process.communicate(timeout=PATIENCE)
    assert (process.returncode, out, err) == ({signal.SIGINT: 130, signal.SIGTERM: 143}[number], "", "")


def test_the_missing_extra_is_named(monkeypatch):
    for name in [
        name for name in sys.modules if name.startswith(("websockets", "cdpr.ui.gui.server", "cdpr.ui.gui.window"))
    ]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "websockets", None)
    result = CliRunner().invoke(cli, ["gui", CAROCA])
    assert str(result.exception) == "cdpr gui needs websockets, not installed: pip install 'cdpr[gui]'"
    assert result.exception.exit_code == 3


def test_a_file_that_is_not_there_opens_nothing():
    result = CliRunner().invoke(cli, ["gui", "nowhere.yaml", "--no-open"])
    assert isinstance(result.exception, CdprError)
    assert "nowhere.yaml" in str(result.exception)
    assert result.output == ""


def test_commands_without_a_window_do_not_import_it():
    """The command and its help are light; no other part uses sockets."""
    program = (
        "import sys; from click.testing import CliRunner; from cdpr.ui.cli import cli; import cdpr; "
        "assert CliRunner().invoke(cli, ['gui', '--help']).exit_code == 0; "
        "import cdpr.ui.gui.server; "
        "print([name for name in ('scipy', 'matplotlib', 'pydantic', 'mujoco') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


def test_an_interrupt_that_python_loses_ends_the_command_all_the_same():
    """It came while no exception could pass, such as at the end of an import."""
    signals = Signals()
    with pytest.raises(KeyboardInterrupt):
        signals.handle(signal.SIGTERM, None)
    with pytest.raises(KeyboardInterrupt):
        _hold(signals)
