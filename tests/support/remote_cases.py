"""Peers that the tests of remote controllers and plants share: programs in a few lines, and the scenario of one."""

from __future__ import annotations

import hashlib
import shutil
import textwrap

from conftest import ROOT

import cdpr

SCENARIOS = ROOT / "scenarios"
SHORT = {"simulation.duration": 0.05}
NONE = "no answer to frame 0 within the time-out, 0.3 s"  # of PEER with such a timeout

PEER = """
import json, os, signal, struct, sys, time
inp, out = sys.stdin.buffer, sys.stdout.buffer
robot = json.loads(inp.readline())
def hello(text=b'{"cdpr": 1}\\n'):
    out.write(text); out.flush()
def frame():
    data = inp.read(8 * robot["sends"])
    if len(data) < 8 * robot["sends"]:
        sys.exit()
    return struct.unpack(f"<{robot['sends']}d", data)
def answer(*values):
    out.write(struct.pack(f"<{len(values)}d", *values)); out.flush()
WEIGHT = (0.0, 0.0, 9.81 * robot["mass"], 0.0, 0.0, 0.0)
"""
GOOD = "hello()\nwhile True: answer(frame()[0], *WEIGHT)"


PLANT = """
m, state = len(robot["cables"]), None
def follow(between=0.0, change=lambda state, count: state):
    global state
    count = 0
    while True:
        sequence, kind, duration, *rest = frame()
        if kind == 2:
            open("stopped", "w").write("safely")
            sys.exit()
        state = rest[m + 6:] if kind == 0 else state
        count += 1
        time.sleep(between)
        answer(sequence, *change(list(state), count))
"""


def scenario(folder, program, name="remote_controller", **changes):
    """A scenario whose peer is this program, which is trusted."""
    file = folder / "peer.py"
    file.write_text(PEER + textwrap.dedent(program))
    for part in ("robots", "remote"):
        if not (folder / part).exists():
            shutil.copytree(SCENARIOS / part, folder / part)
    text = (SCENARIOS / f"{name}.yaml").read_text()
    (folder / "scenario.yaml").write_text(text)
    where = "controller" if name == "remote_controller" else "backend_options.remote"
    sha256 = hashlib.sha256(file.read_bytes()).hexdigest()
    given = {f"{where}.program": "peer.py", f"{where}.sha256": sha256, **SHORT, **changes}
    return cdpr.load_scenario(folder / "scenario.yaml", overrides=given)
