"""Ends of runs with a peer, and the messages until then: interrupts, floods, child processes."""

from __future__ import annotations

import hashlib
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from remote_cases import NONE, PLANT, scenario
from spread import sampled

import cdpr
from cdpr.base.errors import BackendDied
from cdpr.link import transport
from cdpr.link.options import PeerOptions
from cdpr.link.peer import Peer


def started(folder, program, name, *more):
    """A run in its own session, after its peer has reported its process by `begun`."""
    begun = "def begun(): open('pid', 'w').write(str(os.getpid()))"
    scenario(folder, f"{PLANT}\n{begun}\n{program}", name)
    sha256 = hashlib.sha256((folder / "peer.py").read_bytes()).hexdigest()
    where = "controller" if name == "remote_controller" else "backend_options.remote"
    words = [sys.executable, "-m", "cdpr", "run", "scenario.yaml", "--set", f"{where}.program=peer.py"]
    words += ["--set", f"{where}.sha256={sha256}", "--out", "run", *more]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    process = subprocess.Popen(words, cwd=folder, start_new_session=True, **quiet)
    until = time.monotonic() + 30.0
    while not (folder / "pid").exists() or not (folder / "pid").read_text():
        assert time.monotonic() < until
        time.sleep(0.02)
    return process, int((folder / "pid").read_text())


def gone(process):
    """Return True if a process ends within some seconds; a zombie has ended."""
    until = time.monotonic() + 5.0
    while time.monotonic() < until:
        try:
            if Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] == "Z":
                return True
        except OSError:
            return True
        time.sleep(0.02)
    return False


@pytest.mark.slow
@sampled(
    1,
    ("name", "program"),
    [
        ("remote_controller", "hello()\nwhile True: a = frame()[0]; begun(); time.sleep(0.01); answer(a, *WEIGHT)"),
        ("remote_plant", "hello(); follow(0.01, lambda state, count: begun() or state)"),
    ],
)
def test_an_interrupt_in_a_terminal_stops_plants_safely_and_leaves_no_program(tmp_path, name, program):
    """Ctrl-C reaches the whole process group; only cdpr reacts, and notifies the peer."""
    process, peer = started(tmp_path, program, name)
    os.killpg(process.pid, signal.SIGINT)
    assert process.wait(20) == 130
    assert gone(peer)
    assert (tmp_path / "stopped").exists() == (name == "remote_plant")


@pytest.mark.slow
def test_an_interrupt_does_not_wait_for_a_peer_that_hangs(tmp_path):
    process, peer = started(
        tmp_path, "begun(); time.sleep(60)", "remote_controller", "--set", "controller.start_timeout=50.0"
    )
    process.send_signal(signal.SIGINT)
    assert process.wait(10) == 130
    assert gone(peer)


@pytest.mark.parametrize("leader", ["os._exit(4)", "time.sleep(60)"])
def test_child_processes_end_with_the_program(tmp_path, monkeypatch, leader):
    """Also where it keeps the pipes open."""
    monkeypatch.setattr(transport, "GRACE", 0.1)
    program = f"""
    hello(); frame()
    child = os.fork()
    if child == 0:
        time.sleep(60)
    open("child", "w").write(str(child))
    {leader}
    """
    with pytest.raises(BackendDied, match=NONE):
        cdpr.simulate(scenario(tmp_path, program, **{"controller.timeout": 0.3}))
    assert gone(int((tmp_path / "child").read_text()))


@pytest.mark.parametrize(
    ("wrong", "timeout", "said"),
    [("[math.nan] * 13", 10.0, "number 1 of its answer"), ("time.sleep(0.5) or state", 0.2, "no answer")],
)
def test_a_plant_receives_a_stop_after_any_answer(tmp_path, wrong, timeout, said):
    """Also while its answer, which is then not read, is on the way."""
    changes = {"backend_options.remote.timeout": timeout, "backend_options.remote.start_timeout": 10.0}
    program = f"import math\nhello(); follow(0.0, lambda state, count: state if count < 5 else {wrong})"
    with pytest.raises(BackendDied, match=said):
        cdpr.simulate(scenario(tmp_path, f"{PLANT}\n{program}", "remote_plant", **changes))
    assert (tmp_path / "stopped").read_text() == "safely"


def test_attitudes_in_single_precision_will_do(tmp_path):
    program = "hello(); follow(0.0, lambda state, count: [*state[:3], 0.9995, *state[4:]])"
    run = cdpr.simulate(scenario(tmp_path, PLANT + program, "remote_plant"))
    assert run.status == "finished"
    assert np.allclose(np.linalg.norm(run["orientation"], axis=1), 1.0, rtol=0.0, atol=1e-15)


def test_one_that_runs_freely_may_complain_at_length(tmp_path):
    """It does not wait for a reader."""
    program = """
    hello()
    answer(frame()[0], *WEIGHT)
    print("x" * 300000, file=sys.stderr)
    open("said", "w").close()
    while True:
        answer(frame()[0], *WEIGHT)
    """
    changes = {"controller.lockstep": False, "controller.timeout": 60.0, "simulation.duration": 0.2}
    assert cdpr.simulate(scenario(tmp_path, program, **changes), real_time=True).status == "finished"
    assert (tmp_path / "said").exists()


class Endless:
    """A transport on which answers come without end, faster than they are read.

    Attributes:
        given: how many bytes were read.
    """

    called = "peer 'endless'"

    def __init__(self, *about):
        self.given, self.line = 0, b'{"cdpr": 1}\n'

    def send(self, data, until):
        pass

    def send_some(self, data):
        return len(data)

    def receive(self, most, until):
        if self.line:
            most, self.line = self.line[:most], self.line[most:]
            return most
        self.given += most
        assert self.given < 10**6, "it is read without end"
        return bytes(most)

    def close(self, owed):
        pass


def test_one_that_answers_without_end_is_not_read_without_end(monkeypatch):
    monkeypatch.setattr("cdpr.link.peer.Program", Endless)
    options = PeerOptions.model_construct(sha256=None, address=None, timeout=1.0, start_timeout=1.0)
    peer = Peer(options, Path("endless"), {}, 1, 1)
    with pytest.raises(BackendDied, match="answered before frame 0 was sent"):
        peer.newest(np.zeros(1))
    assert peer._transport.given == 1


def test_one_that_complains_without_end_is_not_waited_for_without_end(tmp_path, monkeypatch):
    """Its stderr always has something; its time-out holds all the same."""
    file = tmp_path / "peer.py"
    file.write_text("import sys; sys.stdin.read()")
    program = transport.Program(file, "peer", hashlib.sha256(file.read_bytes()).hexdigest())
    ready = transport.ready
    with monkeypatch.context() as patched:
        patched.setattr(transport, "ready", lambda r, w, until: r[1:] if len(r) == 2 else ready(r, w, until))
        with pytest.raises(TimeoutError):
            program.receive(1, time.monotonic() + 0.1)
    program.close(owed=False)


@pytest.mark.slow
def test_nothing_is_sent_behind_half_a_frame(tmp_path):
    """The last message would be read as the rest of a command."""
    with socket.socket(socket.AF_UNIX) as listening:
        listening.bind(str(tmp_path / "s"))
        listening.listen()
        options = PeerOptions(address=f"unix:{tmp_path}/s", timeout=0.2)
        got = []

        def take():
            with listening.accept()[0] as taken:
                line = taken.makefile("rb").readline()
                taken.sendall(b'{"cdpr": 1}\n')
                time.sleep(0.5)
                while data := taken.recv(65536):
                    got.append(data)
                assert line

        thread = threading.Thread(target=take, daemon=True)
        thread.start()
        peer = Peer(options, None, {}, 10**6, 1)
        with pytest.raises(BackendDied, match="accepts no more data"):
            peer.request(np.zeros(10**6))
        time.sleep(0.5)  # there is room again
        peer.send(np.ones(10**6))
        peer.close()
        thread.join(5.0)
    assert not thread.is_alive()
    assert not any(b"".join(got))


def test_an_interrupt_just_after_a_frame_was_sent_leaves_room_for_the_last(tmp_path, monkeypatch):
    """That frame was whole."""
    with socket.socket(socket.AF_UNIX) as listening:
        listening.bind(str(tmp_path / "s"))
        listening.listen()
        got = []

        def take():
            with listening.accept()[0] as taken, taken.makefile("rb") as stream:
                stream.readline()
                taken.sendall(b'{"cdpr": 1}\n')
                while data := stream.read(16):
                    got.append(np.frombuffer(data).tolist())

        thread = threading.Thread(target=take, daemon=True)
        thread.start()
        peer = Peer(PeerOptions(address=f"unix:{tmp_path}/s", timeout=1.0), None, {}, 1, 1)
        send = transport.Transport.send

        def interrupted(self, data, until):
            send(self, data, until)
            raise KeyboardInterrupt

        with monkeypatch.context() as patched:
            patched.setattr(transport.Transport, "send", interrupted)
            with pytest.raises(KeyboardInterrupt):
                peer.request(np.array([5.0]))
        peer.send(np.array([7.0]))
        peer.close()
        thread.join(5.0)
    assert got == [[0.0, 5.0], [1.0, 7.0]]
