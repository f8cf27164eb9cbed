"""The one HTTP and WebSocket server: access control, malformed requests, idle and slow connections."""

from __future__ import annotations

import errno
import os
import random
import re
import resource
import socket
import subprocess
import sys
import time
import tracemalloc
from contextlib import ExitStack, closing, contextmanager, suppress
from http import HTTPStatus
from typing import ClassVar

import pytest

pytest.importorskip("websockets")

from conftest import ROOT
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.frames import Frame, Opcode
from websockets.server import ServerProtocol
from websockets.sync.client import connect

from cdpr.link import web_server, web_socket
from cdpr.link.access import Access, RefusedError
from cdpr.link.web_server import WebServer, listen, plain_response

CASES = int(os.environ.get("CDPR_WEB_CASES", "400"))  # malformed requests
FLOODS = int(os.environ.get("CDPR_WEB_FLOODS", "2"))  # of 1100 idle connections
TOKEN = "a-token-of-a-test"
PATIENCE = 20.0  # s
KEY = "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: MDEyMzQ1Njc4OWFiY2RlZg==\r\n"
UPGRADE = f"Connection: Upgrade\r\nUpgrade: websocket\r\n{KEY}"


@contextmanager
def served(serve=None, access=None, **options):
    """A server whose WebSockets answer each message by its length."""

    def echo(opened):
        for message in opened:
            opened.send(str(len(message)))

    options = {"most": 4, "max_size": 10**6, "page": lambda host: plain_response(HTTPStatus.OK, "page"), **options}
    server = WebServer(listen("127.0.0.1", 0), access or Access("127.0.0.1", TOKEN), serve or echo, **options)
    with closing(server):
        yield server


def answered(port, data, timeout=PATIENCE):
    """The status of the answer to these bytes; 0 where the connection is closed without one."""
    with socket.create_connection(("127.0.0.1", port), timeout=timeout) as made:
        try:
            made.sendall(data)
            found = made.recv(4096)
        except ConnectionError:
            return 0
        return int(found.split(b" ")[1]) if found else 0


def request(target=f"/?token={TOKEN}", host="127.0.0.1", more=""):
    return f"GET {target} HTTP/1.1\r\nHost: {host}\r\n{more}\r\n".encode()


def link(port):
    return f"ws://127.0.0.1:{port}/?token={TOKEN}"


ADMITTED = [
    ({}, 200),
    ({"host": "localhost:80"}, 200),
    ({"host": "LOCALHOST"}, 200),
    ({"host": "[::1]:99"}, 200),
    ({"target": f"?token={TOKEN}"}, 200),
    ({"target": "/"}, 403),
    ({"target": "/?token="}, 403),
    ({"target": f"/?token={TOKEN}x"}, 403),
    ({"target": f"/?token={TOKEN}&token={TOKEN}"}, 403),
    ({"target": f"/?TOKEN={TOKEN}"}, 403),
    ({"target": f"/other?token={TOKEN}"}, 404),
    ({"target": "//["}, 400),
    ({"target": "/?token=\xfc"}, 400),
    ({"target": "/?" + "a=1&" * 200 + f"token={TOKEN}"}, 400),
    ({"host": "evil.example"}, 421),
    ({"host": "evil.example@127.0.0.1"}, 421),
    ({"host": "127.0.0.1.evil.example"}, 421),
    ({"host": "127.0.0.2"}, 421),
    ({"host": "0.0.0.0"}, 421),
    ({"host": "[::ffff:127.0.0.1]"}, 421),
    ({"host": "[::1"}, 421),
    ({"host": "::1"}, 421),
    ({"host": ""}, 421),
    ({"host": "127.0.0.1;"}, 421),
    ({"host": "127.0.0.1\r\nHost: evil.example"}, 421),
    ({"more": "Origin: http://evil.example\r\n"}, 403),
    ({"more": "Origin: null\r\n"}, 403),
    ({"more": "Origin: http://127.0.0.1\r\n"}, 200),
    ({"more": "Origin: http://127.0.0.1\r\nOrigin: http://evil.example\r\n"}, 403),
    ({"more": f"{UPGRADE}Origin: http://evil.example\r\n"}, 403),
    ({"more": UPGRADE}, 101),
    ({"more": f"Connection: Upgrade\r\nUpgrade: websocket\r\n{KEY.replace('13', '12')}"}, 400),
    ({"more": "Connection: Upgrade\r\nUpgrade: websocket\r\n"}, 400),
    ({"more": "Content-Length: 3\r\n"}, 400),
    ({"more": "x: " + "y" * 9000 + "\r\n"}, 400),
    ({"more": "x: y\r\n" * 5000}, 431),
    ({"target": "/" + "x" * 9000}, 400),
]


def test_admission_of_clients():
    with served() as server:
        for values, status in ADMITTED:
            assert answered(server.port, request(**values)) == status, values
        assert answered(server.port, b"POST / HTTP/1.1\r\n\r\n") in (400, 421)
        assert answered(server.port, request().replace(b"GET", b"HEAD")) in (400, 405)
        assert answered(server.port, b"\n\n") == 400
        assert answered(server.port, b"\x16\x03\x01\x02\0\x01\0\x01\xfc\x03\x03\r\n\r\n") == 400  # TLS


def test_programs_may_need_no_token_but_pages_do():
    access = Access("127.0.0.1", TOKEN, pages=True, programs=True)
    cases = [("/", [], True), ("/?token=", [], True), ("/?token=x", [], False), ("/", ["https://a.example"], False)]
    for target, origins, admitted in [*cases, (f"/?token={TOKEN}", ["https://a.example"], True)]:
        if admitted:
            assert access.check(target, ["127.0.0.1"], origins) == "/"
        else:
            with pytest.raises(RefusedError):
                access.check(target, ["127.0.0.1"], origins)
    with pytest.raises(RefusedError):
        access.check("/", ["rebound.example:8765"], [])


def test_a_server_for_every_address_knows_its_names():
    access = Access("0.0.0.0", TOKEN)
    for host in ("192.168.7.7:8080", "[fe80::1]:8080", socket.gethostname(), "localhost"):
        assert access.check(f"/?token={TOKEN}", [host], []) == "/"
    with pytest.raises(RefusedError):
        access.check(f"/?token={TOKEN}", ["evil.example"], [])


def garbled(chance):
    """A request with some bytes lost, doubled, changed or put elsewhere."""
    parts = [b"GET ", b"/", b"?token=", TOKEN.encode(), b" HTTP/1.1", b"\r\n", b"Host: ", b"127.0.0.1", b"\r\n"]
    parts += [b"Origin: ", b"http://127.0.0.1", b"\r\n", UPGRADE.encode(), b"Sec-WebSocket-Protocol: a, b\r\n"]
    parts += [b"Sec-WebSocket-Extensions: permessage-deflate; x=1\r\n", b"\r\n"]
    odd = [
        b"//[",
        b"http://[::1",
        b"%00",
        b"%zz",
        b"\xff",
        b"\0",
        b"\r",
        b"\n",
        b":",
        b" ",
        b"\t",
        b"//\\",
        b"@",
        b"[",
        b",",
    ]
    odd += [b"Content-Length: -1\r\n", b"Transfer-Encoding: chunked\r\n", b"x" * 9000, "/ü".encode(), b"::", b"=", b";"]
    for _ in range(chance.randrange(1, 4)):
        k = chance.randrange(len(parts) - 1)
        kind = chance.randrange(5)
        if kind == 0:
            parts[k] = b""
        elif kind == 1:
            parts.insert(k, chance.choice(odd))
        elif kind == 2:
            parts[k] = chance.choice(odd)
        elif kind == 3:
            parts.insert(k, chance.choice(parts[:-1]))
        else:
            data = bytearray(parts[k] or b"x")
            data[chance.randrange(len(data))] = chance.randrange(256)
            parts[k] = bytes(data)
    return b"".join(parts)


@pytest.mark.slow
def test_malformed_requests_are_the_clients_fault(monkeypatch):
    monkeypatch.setattr(web_server, "OPENS", 0.2)  # those without an end
    monkeypatch.setattr(web_server, "LINGER", (0.01, 65536))
    chance, found = random.Random(32), {}
    with served(most=CASES) as server:
        for _ in range(CASES):
            data = garbled(chance)
            status = answered(server.port, data)
            found.setdefault(status, data)
        assert answered(server.port, request()) == 200
    assert {status for status in found if status not in (101, 200) and not 400 <= status < 500} == set(), found
    assert len(found) > 4


def test_idle_connections_do_not_block_others(monkeypatch):
    monkeypatch.setattr(web_server, "MOST_WAITING", 8)
    with served() as server, ExitStack() as held:
        first = held.enter_context(socket.create_connection(("127.0.0.1", server.port)))
        for _ in range(100):
            held.enter_context(socket.create_connection(("127.0.0.1", server.port)))
        assert answered(server.port, request()) == 200
        first.settimeout(PATIENCE)
        assert first.recv(1) == b""  # the oldest has been closed
        assert len(server._threads) < 30


@pytest.mark.slow
def test_a_request_takes_a_few_seconds_at_most(monkeypatch):
    monkeypatch.setattr(web_server, "OPENS", 0.3)
    with served() as server, socket.create_connection(("127.0.0.1", server.port), timeout=PATIENCE) as slow:
        begun = time.monotonic()
        with suppress(ConnectionError):
            while time.monotonic() - begun < PATIENCE:  # one byte after the other
                slow.sendall(b"x")
                time.sleep(0.02)
        assert time.monotonic() - begun < PATIENCE


@pytest.mark.slow
def test_many_idle_connections_under_the_usual_limit_of_files():
    """Again and again 1100 connections that send nothing; the page must come meanwhile and afterwards."""
    _, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if hard < 4096:
        pytest.skip("this machine allows fewer than 4096 open files")
    command = ["/bin/sh", "-c", f"ulimit -n 1024; exec {sys.executable} -m cdpr gui --no-open --port 0 caroca"]
    soft = resource.getrlimit(resource.RLIMIT_NOFILE)[0]
    resource.setrlimit(resource.RLIMIT_NOFILE, (4096, hard))
    try:
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=ROOT) as window:
            address = window.stdout.readline().strip()
            port, token = re.search(r":(\d+)/\?token=(.*)", address).groups()
            for _ in range(FLOODS):
                with ExitStack() as held:
                    for _ in range(1100):
                        held.enter_context(socket.create_connection(("127.0.0.1", int(port)), timeout=PATIENCE))
                    assert answered(int(port), request(f"/?token={token}")) == 200
                assert answered(int(port), request(f"/?token={token}")) == 200
            window.terminate()
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


def test_data_directly_after_the_request_is_kept():
    with served() as server, socket.create_connection(("127.0.0.1", server.port), timeout=PATIENCE) as made:
        frame = b"\x81\x83" + bytes(4) + b"abc"  # a masked text of three letters, the mask is zero
        made.sendall(request(more=UPGRADE) + frame)
        found = b""
        while b"\x81\x013" not in found:
            found += made.recv(4096)


@pytest.mark.parametrize(
    ("frame", "code"),
    [
        (b"\x81\x03abc", 1002),  # not masked
        (b"\xf1\x83" + bytes(4) + b"abc", 1002),  # reserved bits
        (b"\x83\x80" + bytes(4), 1002),  # no such kind
        (b"\x80\x83" + bytes(4) + b"abc", 1002),  # a continuation of nothing
        (b"\x89\xfe\x01\x00" + bytes(4 + 256), 1002),  # a long ping
        (b"\x81\x83" + bytes(4) + b"\xff\xfe\xfd", 1007),  # no text
        (b"\x82\xff\x7f\xff\xff\xff\xff\xff\xff\xff" + bytes(4), 1009),  # an endless message
        (b"\x02\xfe\xff\xff" + bytes(4 + 65535) + (b"\x00\xfe\xff\xff" + bytes(4 + 65535)) * 20, 1009),
    ],
)
def test_malformed_frames_close_their_own_connection(frame, code):
    with served() as server, connect(link(server.port)) as other:
        with socket.create_connection(("127.0.0.1", server.port), timeout=PATIENCE) as made:
            made.sendall(request(more=UPGRADE))
            assert b"101" in made.recv(4096)
            made.sendall(frame)
            found = b""
            while data := made.recv(4096):
                found += data
        assert found[:1] == b"\x88"
        assert int.from_bytes(found[2:4], "big") == code
        other.send("1234")
        assert other.recv(timeout=PATIENCE) == "4"


def test_random_frames_are_harmless():
    chance = random.Random(7)
    with served(most=CASES) as server, connect(link(server.port)) as other:
        for _ in range(CASES // 4):
            with socket.create_connection(("127.0.0.1", server.port), timeout=PATIENCE) as made:
                made.sendall(request(more=UPGRADE))
                assert b"101" in made.recv(4096)
                head = bytes(
                    [chance.choice([0x81, 0x82, 0x01, 0x02, 0x00, 0x80, 0x88, 0x89, 0x8A, chance.randrange(256)])]
                )
                with suppress(ConnectionError):
                    for _ in range(chance.randrange(1, 5)):
                        made.sendall(head + chance.randbytes(chance.randrange(20)))
        other.send("1234")
        assert other.recv(timeout=PATIENCE) == "4"


def test_fragments_are_joined():
    with served() as server, connect(link(server.port)) as made:
        made.send(["ab", "cde", "f"])
        assert made.recv(timeout=PATIENCE) == "6"
        made.ping().wait(PATIENCE)


@pytest.mark.slow
def test_a_silent_client_is_pinged_and_given_up(monkeypatch):
    monkeypatch.setattr(web_socket, "QUIET", 1.0)  # a busy machine answers three pings of the first client meanwhile
    with served() as server, connect(link(server.port), ping_interval=None) as alive:
        with socket.create_connection(("127.0.0.1", server.port), timeout=PATIENCE) as silent:
            silent.sendall(request(more=UPGRADE))
            while silent.recv(4096):  # the answer, pings, and the end
                pass
        alive.send("12")
        assert alive.recv(timeout=PATIENCE) == "2"


def test_connections_are_few_and_places_are_given_back():
    with served(most=2) as server:
        with connect(link(server.port)), connect(link(server.port)), pytest.raises(InvalidStatus, match="503"):
            connect(link(server.port)).__enter__()
        until = time.monotonic() + PATIENCE
        while server._open and time.monotonic() < until:
            time.sleep(0.01)
        with connect(link(server.port)) as made:
            made.send("1")
            assert made.recv(timeout=PATIENCE) == "1"
            server.close()
            with pytest.raises(ConnectionClosed):
                made.recv(timeout=PATIENCE)
        assert not server._threads


class Faulty(socket.socket):
    """A listening socket that reports faults of connections before it accepts one, as Linux does (accept(2))."""

    faults: ClassVar = [errno.EPERM, errno.EPROTO, errno.EHOSTUNREACH, errno.EMFILE]

    def accept(self):
        if self.faults:
            code = self.faults.pop()
            raise OSError(code, os.strerror(code))
        return super().accept()


def test_faults_of_connections_do_not_stop_the_server(monkeypatch):
    monkeypatch.setattr(Faulty, "faults", list(Faulty.faults))
    listening = Faulty(fileno=listen("127.0.0.1", 0).detach())
    with closing(WebServer(listening, Access("127.0.0.1", TOKEN), lambda opened: None, most=1, max_size=1)) as server:
        assert answered(server.port, request()) == HTTPStatus.UPGRADE_REQUIRED
    assert Faulty.faults == []


def test_no_other_module_listens():
    """Every server of the program is a WebServer: its access control is the only one."""
    words = re.compile(r"create_server|start_server|\.listen\(|sync\.server|asyncio\.server|http\.server|socketserver")
    files = [file for room in ROOT.glob("cdpr*") if room.is_dir() for file in room.rglob("*.py")]
    assert [file.name for file in files if words.search(file.read_text())] == ["web_server.py"]


class Fragmented(web_socket.WebSocket):
    """A WebSocket whose client sends one message in a great many empty fragments."""

    def _frames(self):
        yield Frame(Opcode.TEXT, b"a", fin=False)
        for _ in range(100_000):
            yield Frame(Opcode.CONT, b"", fin=False)
        yield Frame(Opcode.CONT, b"b")


@pytest.mark.slow
def test_empty_fragments_fill_no_memory():
    with socket.socket() as unconnected:
        opened = Fragmented(unconnected, ServerProtocol(), b"")
        tracemalloc.start()
        try:
            assert list(opened) == ["ab"]
            assert tracemalloc.get_traced_memory()[1] < 100_000  # a list of them takes eight times as much
        finally:
            tracemalloc.stop()
