"""The ROS 2 node's router, domain, command line and missing extra."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
from contextlib import closing, suppress
from functools import partial

import pytest
from command_line import cdpr_here
from live_client import FILE, running
from spread import sampled

from cdpr.base.errors import CdprError

pytest.importorskip("zenoh")
from live_node import WAITS, free_port, node, router

from cdpr.ui.live.ros2 import Ros2


@pytest.mark.parametrize("text", ["-1", "233", "x", "1.5"])
def test_an_impossible_domain_is_reported(text, monkeypatch):
    monkeypatch.setenv("ROS_DOMAIN_ID", text)
    with pytest.raises(CdprError, match=f"ROS_DOMAIN_ID: expected a whole number from 0 to 232, got '{text}'"):
        Ros2(port=free_port())


def test_without_a_router_the_run_continues_and_reports_it():
    chosen = free_port()
    with running(partial(Ros2, port=chosen), duration=0.1) as (link, found, said):
        assert not link.met
        assert link.where.endswith("no router found yet: ros2 run rmw_zenoh_cpp rmw_zenohd")
    assert found["run"].status == "finished"
    assert said == []


@pytest.mark.slow
def test_a_router_may_come_later():
    chosen = free_port()
    begun = running(partial(Ros2, port=chosen), duration=0.2, held=True)
    with begun as (_, found, _), router(chosen), node(chosen) as seen:
        assert seen.trigger("resume") == (True, "")
    assert found["run"].status == "finished"


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (["--live-port", "0"], "--live-port: expected the port of a Zenoh router, mostly 7447, got 0"),
        (
            ["--live-host", "no such host"],
            "--live-host: expected the name or number of a machine, such as 127.0.0.1, got 'no such host' (",
        ),
    ],
)
def test_invalid_router_addresses_are_reported(words, text):
    words = ["run", str(FILE), "--live", "ros2", *words]
    assert text in cdpr_here(*words, code=2).stderr


@pytest.mark.slow
@sampled(1, "module", ["zenoh", "xxhash"])
def test_without_the_extra_the_remedy_is_reported(tmp_path, module):
    code = f"import sys; sys.modules[{module!r}] = None; from cdpr.ui.cli import main; main()"
    words = ["run", str(FILE), "--live", "ros2", "--out", str(tmp_path / "run")]
    done = subprocess.run([sys.executable, "-c", code, *words], capture_output=True, text=True, check=False)
    assert done.returncode == 3
    assert "pip install 'cdpr[live]'" in done.stderr
    assert "Traceback" not in done.stderr


def listening():
    """The ports on which this process listens."""
    held = set()
    for name in os.listdir("/proc/self/fd"):
        with suppress(OSError):
            held.add(os.readlink(f"/proc/self/fd/{name}").removeprefix("socket:[").removesuffix("]"))
    with open("/proc/self/net/tcp") as file:
        rows = [line.split() for line in file.readlines()[1:]]
    return [int(row[1].partition(":")[2], 16) for row in rows if row[3] == "0A" and row[9] in held]


@pytest.mark.slow
@pytest.mark.skipif(not os.path.exists("/proc/self/net/tcp"), reason="needs Linux")
def test_requests_of_web_pages_are_no_handshake():
    """They cannot choose the first bytes, nor read an answer, and Zenoh's handshake needs both."""
    before = set(listening())
    with closing(Ros2(port=free_port())) as link:
        ports = set(listening()) - before
        assert ports
        for port in ports:
            for method in (b"GET", b"POST", b"PUT", b"OPTIONS", b"HEAD", b"DELETE", b"PATCH", b"BREW"):
                for body in (b"", bytes(100), b"\x02\x00\x03\x02" * 20000):
                    head = b"%s /0/cdpr/wrench HTTP/1.1\r\nHost: x\r\nContent-Length: %d\r\n\r\n" % (method, len(body))
                    with (
                        socket.create_connection(("127.0.0.1", port), timeout=WAITS) as made,
                        suppress(OSError),  # it is closed
                    ):
                        made.sendall(head + body)
                        made.shutdown(socket.SHUT_WR)
                        answer = made.recv(1000)
                        assert len(answer) <= 4, answer  # nothing, or a message that closes the transport
        assert link._session.info.peers_zid() == []
        assert link.requests._waiting == type(link.requests._waiting)()
