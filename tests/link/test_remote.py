"""Controllers and plants in other processes: the same bits as here, and every way in which a peer can fail."""

from __future__ import annotations

import hashlib
import json
import os
import re
import shutil
import socket
import subprocess
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from command_line import cdpr_here
from conftest import ROOT
from remote_cases import GOOD, NONE, PLANT, SCENARIOS, SHORT, scenario
from spread import sampled

import cdpr
from cdpr.base.errors import BackendDied, CdprError
from cdpr.link.options import PeerOptions
from cdpr.link.peer import check_peer
from cdpr.log.reader import load_run

# The same sums in another order, over 4 s in a closed loop: m, rad.
TO_ROUND_OFF = 1e-9


def children():
    """Processes that this one has started and that are still there."""
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                words = (entry / "stat").read_text().rpartition(")")[2].split()
                if int(words[1]) == os.getpid() and b"peer.py" in (entry / "cmdline").read_bytes():
                    found.append(entry.name)
            except OSError:
                continue
    return found


def test_the_examples_run(tmp_path):
    for name in ("remote_controller", "remote_plant"):
        words = ("--set", "simulation.duration=0.1", "--out", tmp_path / name)
        done = cdpr_here("run", SCENARIOS / f"{name}.yaml", *words)
        assert "finished" in done.stdout


def test_the_law_is_ours_over_the_wire():
    """The example computes computed torque if the platform hardly rotates."""
    far = {"simulation.duration": 1.0, "trajectory.to.orientation": {"rpy": [0, 0, 0]}}
    there = cdpr.simulate(cdpr.load_scenario(SCENARIOS / "remote_controller.yaml", overrides=far))
    ours = {**far, "controller": {"type": "computed_torque", "kp": 100, "kd": 20}}
    here = cdpr.simulate(cdpr.load_scenario(SCENARIOS / "remote_controller.yaml", overrides=ours))
    assert np.abs(there.position - here.position).max() < TO_ROUND_OFF


def test_lockstep_is_deterministic(tmp_path):
    first, second = (cdpr.simulate(scenario(tmp_path, GOOD)) for _ in range(2))
    assert np.array_equal(first.rows, second.rows)
    assert children() == []


@pytest.mark.slow
def test_a_plant_elsewhere_is_the_plant_here(tmp_path):
    """The peer is cdpr's own reference, called over the wire: the same bits."""
    program = """
    sys.path.insert(0, {root!r})
    import numpy as np, cdpr
    from cdpr.plugins.registry import registry
    loaded = cdpr.load_scenario({file!r})
    entry = registry().get("backend", "reference")
    plant = entry.load()(loaded.robot, np.array(loaded.world.gravity), robot["physics_step"], entry.info.options())
    hello()
    while True:
        sequence, kind, duration, *rest = frame()
        m = len(robot["cables"])
        if kind == 2:
            sys.exit()
        if kind == 0:
            plant.reset(np.array(rest[m + 6:]))
        else:
            plant.command[:], plant.external[:] = rest[:m], rest[m : m + 6]
            plant.step(round(duration / robot["physics_step"]))
        answer(sequence, *plant.state)
    """
    file = str(SCENARIOS / "caroca.yaml")
    scenario(tmp_path, program.format(root=str(ROOT), file=file), "remote_plant")
    here = cdpr.load_scenario(file, overrides={"simulation.duration": 0.2})
    there = cdpr.load_scenario(
        file,
        overrides={
            "simulation.duration": 0.2,
            "backend_options.remote": {
                "program": os.path.relpath(tmp_path / "peer.py", SCENARIOS),
                "sha256": hashlib.sha256((tmp_path / "peer.py").read_bytes()).hexdigest(),
                "start_timeout": 60.0,
            },
        },
        backend="remote",
    )
    assert np.array_equal(cdpr.simulate(here).position, cdpr.simulate(there).position)


FAILING = {
    "ends": ("hello(); frame(); sys.exit(3)", "it ended with code 3"),
    "says why": ("hello(); frame(); sys.exit('the drum is jammed')", "its last words: the drum is jammed"),
    "killed": ("hello(); frame(); os.kill(os.getpid(), signal.SIGKILL)", "it was killed by signal 9"),
    "stopped": ("hello(); frame(); os.kill(os.getpid(), signal.SIGSTOP)", NONE),
    "silent": ("hello(); time.sleep(60)", NONE),
    "short": ("hello(); frame(); answer(0.0, 1.0); time.sleep(60)", NONE),
    "NaN": ("hello(); answer(frame()[0], float('nan'), *WEIGHT[1:])", "number 1 of its answer to frame 0 is nan"),
    "late": (
        "hello(); answer(frame()[0], *WEIGHT); answer(frame()[0] - 1, *WEIGHT)",
        "expected an answer to frame 1, got one to frame 0",
    ),
    "twice": (
        "hello(); a = frame()[0]; answer(a, *WEIGHT); answer(a, *WEIGHT); frame()",
        "expected an answer to frame 1, got one to frame 0|answered before frame 1 was sent",
    ),
    "a fraction": ("hello(); answer(frame()[0] + 0.5, *WEIGHT)", "sequence: expected the number of a frame, got 0.5"),
    "no greeting": ("time.sleep(60)", "did not answer the greeting by a line of JSON within start_timeout, 0.5 s"),
    "expected JSON": ("hello(b'hello\\n')", "expected .* and a new line"),
    "another version": ("hello(b'{\"cdpr\": 9}\\n')", "speaks version 9 of the protocol, not 1"),
    "endless greeting": ("hello(b'x' * 100000)", "its greeting is longer than 65536 bytes"),
}


# By default one that waits until a timeout; the others do, too.
@sampled(lambda case: case not in ("stopped", "short", "no greeting", "endless greeting"), "case", FAILING)
def test_a_peer_that_fails_ends_the_run(tmp_path, case):
    program, said = FAILING[case]
    quick = {"controller.timeout": 0.3, "controller.start_timeout": 0.5 if case == "no greeting" else 10.0}
    with pytest.raises(BackendDied, match=said) as caught:
        cdpr.simulate(scenario(tmp_path, program, **quick))
    assert caught.value.exit_code == 6
    assert children() == []


def test_a_run_that_a_peer_ended_is_whole_up_to_there(tmp_path):
    program = "hello()\nfor _ in range(20): answer(frame()[0], *WEIGHT)\nsys.exit(1)"
    scenario(tmp_path, program)
    sha256 = hashlib.sha256((tmp_path / "peer.py").read_bytes()).hexdigest()
    words = ("--set", "controller.program=peer.py", "--set", f"controller.sha256={sha256}", "--out", "run")
    done = cdpr_here("run", "scenario.yaml", *words, code=6, cwd=tmp_path)
    assert "peer 'peer.py': it ended with code 1" in done.stderr
    assert 20 <= len(load_run(tmp_path / "run").rows) <= 21


def test_verbose_programs_continue(tmp_path):
    """Its output on stderr does not fill a pipe and block it."""
    program = (
        "hello()\nwhile True:\n    a = frame()[0]\n    print('x' * 100000, file=sys.stderr)\n    answer(a, *WEIGHT)"
    )
    assert cdpr.simulate(scenario(tmp_path, program)).status == "finished"


def test_a_program_runs_only_with_its_checksum(tmp_path):
    loaded = scenario(tmp_path, GOOD)
    (tmp_path / "peer.py").write_text("open('ran', 'w')")
    with pytest.raises(CdprError, match="its checksum differs from the one in the scenario"):
        cdpr.simulate(loaded)
    bare = (SCENARIOS / "remote_controller.yaml").read_text()
    bare = "\n".join(line for line in bare.splitlines() if "sha256" not in line)
    (tmp_path / "scenario.yaml").write_text(bare)
    with pytest.raises(CdprError, match=r"is not trusted to run: inspect it, .* write sha256: [0-9a-f]{64}"):
        cdpr.simulate(cdpr.load_scenario(tmp_path / "scenario.yaml"))
    assert not (tmp_path / "ran").exists()


@pytest.mark.parametrize(
    ("text", "mode", "said"),
    [
        ("#!/bin/sh\n", 0o644, "cannot be started: Permission denied: 'chmod +x' makes a file a program"),
        ("\x7f", 0o755, "cannot be started: Exec format error: a script begins with #!"),
        ("#!/nowhere/perl\n", 0o755, "the interpreter behind its #! is not there"),
    ],
)
def test_programs_that_do_not_start_are_reported_with_a_remedy(tmp_path, text, mode, said):
    peer = tmp_path / "peer"
    peer.write_text(text)
    peer.chmod(mode)
    trusted = hashlib.sha256(peer.read_bytes()).hexdigest()
    changes = {"controller.program": str(peer), "controller.sha256": trusted}
    with pytest.raises(CdprError, match=re.escape(said)):
        cdpr.simulate(cdpr.load_scenario(SCENARIOS / "remote_controller.yaml", overrides=changes))


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"controller.address": "127.0.0.1:1"}, r"set either `program` \(command to start\) or `address`"),
        ({"controller.program": "remote/lost.py"}, "peer 'lost.py': no such file"),
        ({"controller.program": "remote"}, "peer 'remote': no such file"),
        ({"controller.timeout": 0.0}, "must be greater than 0"),
    ],
)
def test_invalid_peers_are_reported_before_the_run(changes, said):
    with pytest.raises(CdprError, match=said):
        cdpr.simulate(cdpr.load_scenario(SCENARIOS / "remote_controller.yaml", overrides={**SHORT, **changes}))


def at(address, **changes):
    text = (SCENARIOS / "remote_controller.yaml").read_text().replace("program: remote/law.py", f"address: '{address}'")
    text = "\n".join(line for line in text.splitlines() if "sha256" not in line)
    return cdpr.load_scenario(SCENARIOS / "elsewhere.yaml", text=text, overrides={**SHORT, **changes})


@pytest.mark.parametrize(
    "address", ["127.0.0.1", "127.0.0.1:0", "127.0.0.1:99999", ":80", "localhost:http", "a..b:80", f"{'x' * 64}.com:80"]
)
def test_an_address_is_one(address):
    with pytest.raises(CdprError, match="HOST:PORT, with a port from 1 to 65535"):
        cdpr.simulate(at(address))


@pytest.mark.parametrize("path", ["", "/" + "x" * 107, "/a\0b"])
def test_the_path_of_a_socket_is_one(path):
    with pytest.raises(CdprError, match="the path of a socket must have 1 to 107 bytes"):
        check_peer(PeerOptions(address=f"unix:{path}"), None)


@pytest.mark.slow
def test_no_peer_at_the_address(tmp_path):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))  # and does not listen
        port = taken.getsockname()[1]
        with pytest.raises(BackendDied, match=r"no connection within start_timeout, 0\.2 s"):
            cdpr.simulate(at(f"127.0.0.1:{port}", **{"controller.start_timeout": 0.2}))
        setting = {"address": f"127.0.0.1:{port}", "start_timeout": 0.2}
        words = [word for key, value in setting.items() for word in ("--set", f"controller.{key}={value}")]
        out = tmp_path / "out"
        for _ in range(2):  # nothing is left of the first that would refuse the second
            done = cdpr_here("run", "caroca", "--controller", "remote", *words, "--out", out, code=6)
            assert f"waiting up to 0.2 s for peer '127.0.0.1:{port}'" in done.stderr
        assert list(out.iterdir()) == []


def serve(listening, delay=0.0):
    """Answer one run with the weight, as a peer that listens does."""
    time.sleep(delay)
    listening.listen()
    with listening.accept()[0] as peer:
        stream = peer.makefile("rwb")
        robot = json.loads(stream.readline())
        stream.write(b'{"cdpr": 1}\n')
        stream.flush()
        while len(data := stream.read(8 * robot["sends"])) == 8 * robot["sends"]:
            stream.write(np.array([np.frombuffer(data)[0], 0, 0, 9.81 * robot["mass"], 0, 0, 0]).tobytes())
            stream.flush()


@pytest.mark.parametrize("kind", ["tcp", "unix"])
def test_one_that_listens_is_found_even_late(tmp_path, kind):
    family = socket.AF_INET if kind == "tcp" else socket.AF_UNIX
    with socket.socket(family) as listening:
        listening.bind(("127.0.0.1", 0) if kind == "tcp" else str(tmp_path / "s"))
        name = f"127.0.0.1:{listening.getsockname()[1]}" if kind == "tcp" else f"unix:{tmp_path}/s"
        thread = threading.Thread(target=serve, args=(listening, 0.3), daemon=True)
        thread.start()
        run = cdpr.simulate(at(name))
        thread.join(5.0)
        assert not thread.is_alive()
    assert run.status == "finished"


@pytest.mark.slow
def test_free_running_holds_the_newest_answer_and_is_refused_where_runs_must_be_equal(tmp_path):
    loaded = scenario(tmp_path, GOOD, **{"controller.lockstep": False})
    run = cdpr.simulate(loaded)
    assert run.status == "finished"
    slow = "hello(); answer(frame()[0], *WEIGHT); time.sleep(60)"
    changes = {"controller.lockstep": False, "controller.timeout": 0.2, "simulation.duration": 900.0}
    silent = scenario(tmp_path, slow, **changes)
    with pytest.raises(BackendDied, match="no answer lately within the time-out"):
        cdpr.simulate(silent)
    file = SCENARIOS / "remote_controller.yaml"
    for words in (("compare", file), ("baseline", "save", file, "--out", tmp_path / "kept")):
        done = cdpr_here(*words, "--set", "controller.lockstep=false", code=2, cwd=tmp_path)
        assert "requires reproducible runs" in done.stderr
    study = {
        "scenario": os.path.relpath(file, tmp_path),
        "axes": [{"name": "free", "key": "controller.lockstep", "values": [True, False]}],
    }
    (tmp_path / "study.yaml").write_text(json.dumps(study))
    done = cdpr_here("study", tmp_path / "study.yaml", "--dry-run", code=2, cwd=tmp_path)
    assert "requires reproducible runs" in done.stderr


def test_commands_never_leave_their_limits(tmp_path):
    """For any command of the controller, an external plant receives commands within the limits."""
    program = """
    hello()
    low, high, m = robot["tension_min"], robot["tension_max"], len(robot["cables"])
    state = None
    while True:
        sequence, kind, duration, *rest = frame()
        if not all(a <= t <= b for a, t, b in zip(low, rest, high)):
            sys.exit("a command was outside of its limits")
        if kind == 2:
            open("stopped", "w").write("safely")
            sys.exit()
        state = rest[m + 6:] if kind == 0 else state
        answer(sequence, *state)
    """
    loaded = scenario(tmp_path, program, "remote_plant", **{"controller.kp": 1e6, "solver": {"type": "pseudo_inverse"}})
    cdpr.simulate(loaded)
    assert (tmp_path / "stopped").read_text() == "safely"


def test_commands_that_are_not_sent_are_reported(tmp_path):
    """The command of a broken cable is 0, which the limits do not allow."""
    broken = {"events": [{"type": "cable_break", "time": 0.03, "cable": "cable_1"}]}
    told = r"in 20 of 50 control steps commands beyond the limits .* were clipped"
    with pytest.warns(UserWarning, match=told):
        run = cdpr.simulate(scenario(tmp_path, PLANT + "hello(); follow()", "remote_plant", **broken))
    assert run.tension[-1, 0] == 0.0


def test_a_state_that_is_none_ends_the_run(tmp_path):
    program = "hello()\nwhile True: answer(frame()[0], *[0.3] * 13)"
    with pytest.raises(BackendDied, match="whose length is not 1"):
        cdpr.simulate(scenario(tmp_path, program, "remote_plant", **{"backend_options.remote.start_timeout": 10.0}))


def test_real_time_counts_what_comes_late(tmp_path):
    program = """
    hello()
    m, state, count = len(robot["cables"]), None, 0
    while True:
        sequence, kind, duration, *rest = frame()
        state = rest[m + 6:] if kind == 0 else state
        count += 1
        time.sleep(0.02 if count == 10 else 0.0)
        answer(sequence, *state)
    """
    started = time.monotonic()
    with pytest.warns(UserWarning, match=r"of 50 control steps came more than one step too late, by up to"):
        run = cdpr.simulate(scenario(tmp_path, program, "remote_plant", **{"backend_options.remote.real_time": True}))
    assert time.monotonic() - started >= 0.05
    assert np.nanmax(run["step_late"]) > 0.01


@pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler")
def test_one_in_another_language(tmp_path):
    source = SCENARIOS / "remote" / "law.c"
    subprocess.run(["cc", "-O2", "-Wall", "-Werror", "-o", tmp_path / "law", source], check=True)
    sha256 = hashlib.sha256((tmp_path / "law").read_bytes()).hexdigest()
    program = os.path.relpath(tmp_path / "law", SCENARIOS)
    changes = {"controller.program": program, "controller.sha256": sha256, "simulation.duration": 1.0}
    run = cdpr.simulate(cdpr.load_scenario(SCENARIOS / "remote_controller.yaml", overrides=changes))
    assert run.status == "finished"
    assert np.abs(run.position[-1] - run.desired_position[-1]).max() < 1e-3
