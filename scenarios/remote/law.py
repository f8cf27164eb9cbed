"""A controller in 30 lines, without cdpr: inverse dynamics with proportional and damping terms, for any platform."""

import json
import struct
import sys

KP, KD = 100.0, 20.0  # 1/s^2, 1/s


def read(count: int) -> tuple[float, ...]:
    """Read this many little-endian 64-bit floats; the end of a run ends this program."""
    data = sys.stdin.buffer.read(8 * count)
    return struct.unpack(f"<{count}d", data) if len(data) == 8 * count else sys.exit()


robot = json.loads(sys.stdin.buffer.readline())
sys.stdout.buffer.write(b'{"cdpr": 1}\n')
sys.stdout.buffer.flush()
while True:
    sequence, time, *now = read(robot["sends"])
    p, q, v, w = now[0:3], now[3:7], now[7:10], now[10:13]  # position, attitude w x y z, velocity, angular velocity
    p1, q1, v1, w1, a1, b1 = now[13:16], now[16:20], now[20:23], now[23:26], now[26:29], now[29:32]  # desired
    push = [a1[i] + KP * (p1[i] - p[i]) + KD * (v1[i] - v[i]) - robot["gravity"][i] for i in range(3)]
    force = [robot["mass"] * part for part in push]
    swap = [q1[3] * q[2] - q1[2] * q[3], q1[1] * q[3] - q1[3] * q[1], q1[2] * q[1] - q1[1] * q[2]]
    side = 2.0 if sum(a * b for a, b in zip(q, q1, strict=True)) >= 0.0 else -2.0
    turn = [side * (q[0] * q1[1 + i] - q1[0] * q[1 + i] + swap[i]) for i in range(3)]  # what is left to turn, rad
    spin = [b1[i] + KP * turn[i] + KD * (w1[i] - w[i]) for i in range(3)]
    moment = [sum(robot["inertia"][i][j] * spin[j] for j in range(3)) for i in range(3)]  # for small attitudes
    sys.stdout.buffer.write(struct.pack("<7d", sequence, *force, *moment))
    sys.stdout.buffer.flush()
