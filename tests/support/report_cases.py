"""Synthetic runs for the tests of cdpr.ui.report, and the promise that each of them can be drawn."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from cdpr.log.event import Event
from cdpr.log.header import Header
from cdpr.log.layout import Layout
from cdpr.log.run import Run
from cdpr.model.robot import Array

STEP = 0.001  # s
MASS = 60.0
SIZE = (1.2, 0.6, 0.4)
SCENARIO = "# a <scenario> & more\nrobot: robots/caroca.yaml\nsimulation:\n  duration: 4.0  # s\n"

# A motion of a tool, for who draws its way.
LED = {
    "robot.platform.tools": {"nozzle": [0.3, 0.1, -0.4], "eye": [0.0, 0.0, 0.2]},
    "initial.position": [0.0, 0.0, 1.4],
    "trajectory": {
        "type": "quintic",
        "tool": "nozzle",
        "duration": 0.8,
        "to": {"position": [0.6, 0.2, 1.2], "orientation": {"rpy": [0.0, 0.0, 1.0]}},
    },
    "simulation.duration": 1.0,
}


def anchors_of(m: int) -> Array:
    """Anchors of a robot in a frame of 7 x 4 x 3.5 m: crossed, upper cables to lower corners."""
    corners = [(sx, sy, sz) for sz in (1, -1) for sx, sy in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    rows = []
    for i in range(m):
        sx, sy, sz = corners[i % 8]
        shift = 0.5 * (i // 8)
        frame = (3.5 * sx, (2.0 - shift) * sy, 1.75 + 1.75 * sz)
        rows.append((*frame, 0.5 * SIZE[0] * sx, 0.5 * SIZE[1] * sy, -0.5 * SIZE[2] * sz))
    return np.array(rows)


def make_run(
    rows: int = 4001,
    m: int = 8,
    names: tuple[str, ...] | None = None,
    limits: tuple[float, float] = (20.0, 650.0),
    noise: float = 0.02,
) -> Run:
    """Return a run of 1 kHz: a quintic move for three quarters of the time, errors near 0.2 mm, then rest."""
    header = Header(
        scenario="caroca",
        robot="caroca",
        backend="reference",
        controller="computed_torque",
        solver="qp",
        control_step=STEP,
        physics_step=STEP,
        seed=0,
        gravity=(0.0, 0.0, -9.81),
        mass=MASS,
        cables=names or tuple(f"cable_{i + 1}" for i in range(m)),
        anchors=tuple(tuple(float(x) for x in row) for row in anchors_of(m)),
        tension_min=(limits[0],) * m,
        tension_max=(limits[1],) * m,
        characteristic_length=0.7,
        shape={"box": list(SIZE)},
        versions={"cdpr": "0.1.0", "python": "3.11.7", "numpy": "2.4.6"},
        scenario_yaml=SCENARIO,
    )
    table = _table(rows, m, limits, noise)
    return Run(header, table, message="reached 4 s", timings={"loop_s": 1.6}, unused=("controller.kd",))


@lru_cache(maxsize=4)
def _table(rows: int, m: int, limits: tuple[float, float], noise: float) -> Array:
    layout = Layout(m)
    columns, table = layout.columns, np.zeros((rows, layout.width))
    t = np.arange(rows) * STEP
    T = max(0.75 * t[-1], 1e-3)
    s = np.clip(t / T, 0.0, 1.0)[:, None]
    rise, slope, bend = (
        s**3 * (10 - 15 * s + 6 * s**2),
        30 * (s * (1 - s)) ** 2 / T,
        60 * s * (1 - s) * (1 - 2 * s) / T**2,
    )
    way, turn = np.array([1.5, 0.5, 0.4]), np.array([0.05, -0.1, 0.3])
    position = np.array([0.0, 0.0, 1.2]) + rise * way
    random = np.random.default_rng(1)
    lag = 2e-4 * np.sin(2 * np.pi * 3 * t[:, None] + np.array([0.0, 1.0, 2.0])) * np.exp(-0.5 * t[:, None])
    lag += noise * 2e-4 * random.standard_normal((rows, 3))

    def put(name: str, values: Array) -> None:
        table[:, columns[name]] = values.reshape(rows, -1)

    put("time", t)
    put("desired_position", position)
    put("desired_velocity", slope * way)
    put("desired_acceleration", bend * way)
    put("desired_angular_velocity", slope * turn)
    put("desired_angular_acceleration", bend * turn)
    put("position", position + lag)
    put("velocity", slope * way + np.gradient(lag, axis=0) / 1e-3 if rows > 1 else slope * way)
    put("angular_velocity", slope * turn)
    put("desired_orientation", _attitudes(turn, rise[:, 0]))
    put("orientation", _attitudes(turn, rise[:, 0] + lag[:, 0]))

    A, B = (anchors_of(m)[:, part] for part in (slice(0, 3), slice(3, 6)))
    vectors = A - position[:, None, :] - B
    length = np.linalg.norm(vectors, axis=2)
    u = vectors / length[:, :, None]
    W = np.concatenate([u, np.cross(np.broadcast_to(B, u.shape), u)], axis=2).transpose(0, 2, 1)
    wrench = np.zeros((rows, 6))
    wrench[:, :3] = MASS * (bend * way + np.array([0.0, 0.0, 9.81]))
    wanted = np.full((rows, m), 330.0)
    tension = wanted + np.einsum("kij,kj->ki", np.linalg.pinv(W), wrench - np.einsum("kij,kj->ki", W, wanted))
    tension += 4 * noise * random.standard_normal((rows, m)) + 2 * np.sin(2 * np.pi * 3 * t)[:, None]
    tension = np.clip(tension, *limits)
    put("wrench", wrench)
    put("tension", tension)
    put("length", length)
    put("rate", -np.einsum("kij,kj->ki", u, slope * way))
    put("residual", 1e-12 * (1 + random.random(rows)))
    margin = np.minimum(tension - limits[0], limits[1] - tension).min(axis=1)
    put("margin", margin)
    put("at_limit", (margin <= 0.0).astype(float))
    kinetic, potential = 0.5 * MASS * np.sum((slope * way) ** 2, axis=1), MASS * 9.81 * position[:, 2]
    put("kinetic", kinetic)
    put("potential", potential)
    put("cable_work", kinetic + potential - potential[0])
    table.flags.writeable = False
    return table


def _attitudes(turn: Array, parts: Array) -> Array:
    """Quaternions of parts of a rotation vector."""
    angle = float(np.linalg.norm(turn))
    half = 0.5 * angle * parts[:, None]
    return np.concatenate([np.cos(half), np.sin(half) * turn / angle], axis=1)


def infeasible_run() -> Run:
    run = make_run()
    table = run.rows.copy()
    columns = run.header.layout.columns
    table[900:1100, columns["status"]] = 1
    table[900:1100, columns["residual"]] = 42.0
    table[1300, columns["status"]] = 2
    table[900:1100, columns["tension"]][:, 2] = 50.0
    table[900:1100, columns["margin"]] = 0.0
    events = (
        Event(0.9, "infeasible", "no tensions within the limits balance the wrench", until=1.1),
        Event(1.3, "infeasible", "the solver gave up", until=1.301),
        Event(3.2, "note", "the platform came to rest"),
    )
    return replace(run, rows=table, events=events)


def diverged_run(last: float = np.inf) -> Run:
    run = make_run(rows=1200)
    table = run.rows.copy()
    columns = run.header.layout.columns
    growth = 1e-6 * np.exp(np.arange(200) / 4.0)[:, None]
    for name in ("position", "velocity", "angular_velocity", "tension", "length", "rate"):
        table[1000:, columns[name]] += growth
    table[-1, columns["position"]] = last
    table[-1, columns["tension"]] = np.nan
    event = Event(1.199, "diverged", "the position is not finite")
    return replace(run, rows=table, status="diverged", message="stopped at 1.199 s", events=(event,))


CASES = {
    "plain": make_run,
    "infeasible": infeasible_run,
    "diverged": diverged_run,
    "interrupted": lambda: replace(
        make_run(rows=777), status="interrupted", message="", events=(Event(0.776, "interrupted", "Ctrl-C"),)
    ),
    "no row": lambda: replace(make_run(rows=2), rows=make_run(rows=2).rows[:0]),
    "one row": lambda: make_run(rows=1),
    "two rows": lambda: make_run(rows=2),
    "one cable": lambda: make_run(rows=50, m=1),
    "12 cables": lambda: make_run(m=12),
    "long names": lambda: make_run(
        names=tuple(f"upper_platform_winch_number_{i}_{w}" for i, w in enumerate(["left", "right"] * 4))
    ),
    "far limits": lambda: make_run(limits=(1.0, 20000.0)),
    "noisy": lambda: make_run(noise=1.0),
    "100000 rows": lambda: make_run(rows=100_000),
}
