"""A plant without cdpr: a point mass on massless cables, by semi-implicit Euler; a robot would answer as it does."""

import json
import math
import struct
import sys

START, STEP, STOP = 0, 1, 2


def read(count: int) -> tuple[float, ...]:
    """Read this many little-endian 64-bit floats; the end of a run ends this program."""
    data = sys.stdin.buffer.read(8 * count)
    return struct.unpack(f"<{count}d", data) if len(data) == 8 * count else sys.exit()


robot = json.loads(sys.stdin.buffer.readline())
anchors, mass, gravity, m = robot["anchors"], robot["mass"], robot["gravity"], len(robot["cables"])
sys.stdout.buffer.write(b'{"cdpr": 1}\n')
sys.stdout.buffer.flush()
state = [0.0] * 13
while True:
    sequence, kind, duration, *rest = read(robot["sends"])
    tension, external, given = rest[:m], rest[m : m + 6], rest[m + 6 :]
    if kind == STOP:
        sys.exit()
    if kind == START:
        state = list(given)
    for _ in range(round(duration / robot["physics_step"])):
        force = [mass * gravity[i] + external[i] for i in range(3)]
        for pull, anchor in zip(tension, anchors, strict=True):
            way = [anchor[i] - state[i] - anchor[3 + i] for i in range(3)]
            length = math.hypot(*way)
            force = [force[i] + pull * way[i] / length for i in range(3)]
        for i in range(3):
            state[7 + i] += robot["physics_step"] * force[i] / mass
            state[i] += robot["physics_step"] * state[7 + i]
    sys.stdout.buffer.write(struct.pack("<14d", sequence, *state))
    sys.stdout.buffer.flush()
