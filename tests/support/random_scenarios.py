"""Random scenarios that sound engines must agree on: slack cables, jumps, winches, pulleys, friction, any platform."""

from __future__ import annotations

import numpy as np
import yaml

import cdpr
from cdpr.model import rotations

FREE = ["x", "y", "z", "rx", "ry", "rz"]
PLATFORMS = {  # directions that move, and cables at least
    "space": (FREE, 8),
    "point": (["x", "y", "z"], 4),
    "plane": (["x", "z", "ry"], 4),
    "flat point": (["x", "z"], 3),
    "ball": (["rx", "ry", "rz"], 5),
}
CABLES = ("ideal", "stiff", "soft", "slack")
DURATION, STEP = 0.3, 0.002


def scenario(seed, **changes):
    """The scenario of a seed."""
    rng = np.random.default_rng(seed)
    dof, least = PLATFORMS[rng.choice(list(PLATFORMS))]
    span, mass = float(10 ** rng.uniform(-0.3, 1.0)), float(10 ** rng.uniform(-0.5, 2.0))
    model = str(rng.choice(CABLES))
    turns = [name for name in dof if name.startswith("r")]
    home = [float(rng.uniform(-0.1, 0.1) * span) if name in dof else 0.0 for name in ("x", "y", "z")]
    robot = {
        "dof": dof,
        "platform": {"mass": mass},
        "tension": {"min": 0.0 if model == "slack" else 0.05 * mass * 9.81, "max": 40.0 * mass * 9.81},
        "home": {"position": home},
        "cables": [_cable(rng, k, least + 2, span, dof) for k in range(least + int(rng.integers(3)))],
    }
    if turns:
        arm = 0.1 * span
        robot["platform"]["inertia"] = [mass * arm**2 * float(rng.uniform(0.5, 1.0)) for _ in range(3)] + [0.0] * 3
    if len(turns) == 3:
        robot["platform"]["center_of_mass"] = (0.03 * span * rng.uniform(-1, 1, 3)).tolist()
    if rng.random() < 0.3:
        _on_pulleys(rng, robot, span)
    if model != "ideal":
        strength = {"stiff": 1e3, "soft": 100.0, "slack": 300.0}[model] * mass * 9.81
        robot["cable"] = {"model": "elastic", "axial_stiffness": strength, "damping": 5e-4 * strength}
        robot["winch"] = {"drum_radius": 0.04, "inertia": 2e-5 * mass}
        if rng.random() < 0.5:
            friction = {"viscous_friction": 1e-4 * mass, "coulomb_friction": 2e-3 * mass, "coulomb_speed": 1.0}
            robot["winch"] |= friction
    return _loaded({**_motion(rng, robot, span, home, turns, mass), "name": f"random_{seed}"}, changes)


def _loaded(plain, changes):
    return cdpr.load_scenario("random.yaml", text=yaml.safe_dump(plain), overrides=changes)


def _cable(rng, k, count, span, dof):
    """A cable from somewhere on a sphere; neighbours are far apart."""
    turn, height = 2 * np.pi * (k + rng.uniform(-0.3, 0.3)) / (count - 2), (-1) ** k * rng.uniform(0.4, 1.0)
    frame = span * np.array([np.cos(turn), np.sin(turn), height])
    platform = 0.1 * span * rng.uniform(-1, 1, 3)
    if "y" not in dof and "x" in dof:
        frame[1] = platform[1] = 0.0
        frame[[0, 2]] = span * np.array([np.cos(turn), np.sin(turn)])
    if not any(name.startswith("r") for name in dof):
        platform[:] = 0.0
    return {"frame": frame.tolist(), "platform": platform.tolist()}


def _on_pulleys(rng, robot, span):
    for cable in robot["cables"]:
        cable["exit"] = {"type": "pulley", "radius": float(0.02 * span * rng.uniform(0.5, 1.0)), "axis": [0, 0, 1]}


def _motion(rng, robot, span, home, turns, mass):
    """A motion, its control, and what pushes."""
    target = [
        p + float(rng.uniform(-0.05, 0.05) * span) if n in robot["dof"] else p for p, n in zip(home, "xyz", strict=True)
    ]
    to = {"position": target}
    if turns:
        turn = rng.uniform(-0.15, 0.15, 3) * [name in turns for name in ("rx", "ry", "rz")]
        to["orientation"] = {"quaternion": rotations.from_axis_angle(turn / np.linalg.norm(turn), 0.15).tolist()}
    rate = float(rng.uniform(5.0, 9.0))
    controllers = [{"type": "computed_torque", "kp": rate**2, "kd": 1.6 * rate}]
    plain = {
        "robot": robot,
        "simulation": {"duration": DURATION, "control_step": STEP, "physics_step": STEP / int(rng.integers(2, 6))},
        "initial": {"position": home},
        "trajectory": {"type": "quintic", "duration": 0.25, "to": to},
        "controller": controllers[0],
        "events": [],
    }
    if rng.random() < 0.6:  # a jump of the load
        force = 0.5 * mass * 9.81 * rng.uniform(-1, 1, 3) * [name in robot["dof"] for name in "xyz"]
        moment = 0.02 * span * mass * 9.81 * rng.uniform(-1, 1, 3) * [name in turns for name in ("rx", "ry", "rz")]
        push = {"type": "wrench", "time": 0.1, "duration": 0.1, "force": force.tolist(), "moment": moment.tolist()}
        plain["events"].append(push)
    return plain
