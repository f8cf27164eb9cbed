"""Verdicts on random loops against runs: stable ones stay bounded, unstable ones do not."""

from __future__ import annotations

import math
import os

import numpy as np
import pytest

import cdpr
from cdpr.base.errors import CdprError, SimulationStopped
from cdpr.simulation.build import faults
from cdpr.simulation.linearised import linearise
from cdpr.simulation.linearised_scenario import NotLinearisedError
from cdpr.simulation.poles import STABLE, UNSTABLE, verdict

LOOPS = int(os.environ.get("CDPR_TEST_CASES", "10"))
SEED = int(os.environ.get("CDPR_TEST_SEED", "1"))
DECADES = 5.0  # of the amplitude, in a run of an unstable loop
SHORTEST, LONGEST = 300, 10000  # control steps
PUSH = 1e-7  # m/s: within the range in which the loop is linear
FAR = 1e-5  # m: limits hold fast unstable loops near this or farther, within a tenth of the run
GROWN = 30.0  # factor that a stable loop may reach: modes are not perpendicular


def random_loop(rng):
    """Return a random scenario at rest: a point mass or a crossed platform, on random cables, winches and gains."""
    mass, height = 10 ** rng.uniform(0.0, 2.0), rng.uniform(2.0, 4.0)
    corners = [(x, y, z) for z in (height, 0.0) for x, y in ((-2, -1.5), (2, -1.5), (2, 1.5), (-2, 1.5))]
    solid = rng.random() < 0.3
    cables = []
    for x, y, z in corners:
        end = [0.1 * (-x if z else x), 0.1 * (y if z else -y), -0.1 if z else 0.1] if solid else [0.0, 0.0, 0.0]
        cables.append({"frame": [x, y, z], "platform": end})
    robot = {
        "name": "random",
        "platform": {"mass": mass}
        | ({"inertia": (mass * np.array([0.02, 0.03, 0.04, 0, 0, 0])).tolist()} if solid else {}),
        "tension": {"min": mass, "max": 1000.0 * mass},
        "home": {"position": [*rng.uniform(-0.4, 0.4, 2).tolist(), float(0.5 * height + rng.uniform(-0.3, 0.3))]},
        "cables": cables,
    } | ({} if solid else {"dof": ["x", "y", "z"]})
    period = 0.001 * 2 ** int(rng.integers(0, 5))
    width = 10 ** rng.uniform(-0.5, 0.6 if rng.random() < 0.5 else 0.3) / period / 4.0  # of the controller, 1/s
    ratio = 10 ** rng.uniform(-1.0, 0.3)
    gains = {"kp": float(width**2), "kd": float(2.0 * ratio * width)}
    kind = str(rng.choice(["computed_torque", "static", "pid"]))
    if kind == "pid":
        gains["ki"] = float(width**3 * 10 ** rng.uniform(-2.0, 0.5))
    controller = {"type": kind, **gains}
    if rng.random() < 0.6:
        stiffness = mass * 10 ** rng.uniform(2.5, 5.0)
        critical = 2.0 * math.sqrt(mass * stiffness / 2.5)
        robot["cable"] = {
            "model": "elastic",
            "axial_stiffness": float(stiffness),
            "damping": float(critical * 10 ** rng.uniform(-2.5, -0.3)),
        }
        drum = {"drum_radius": 0.05, "inertia": float(0.05**2 * mass * 10 ** rng.uniform(-1.5, 0.3))}
        robot["winch"] = drum | {"viscous_friction": float(drum["inertia"] * 10 ** rng.uniform(-1.0, 1.0))}
        servo = rng.random()
        if servo < 0.4:
            speed = 10 ** rng.uniform(1.0, 2.5)  # of the velocity loop, 1/s
            loops = {"velocity_gain": float(drum["inertia"] * speed), "position_gain": float(0.3 * speed)}
            loops["integral_gain"] = float(drum["inertia"] * speed**2 * 10 ** rng.uniform(-2.0, 0.0))
            if rng.random() < 0.5:
                loops["torque_lag"] = float(10 ** rng.uniform(-0.5, 1.0) / speed)
            robot["winch"] |= {"type": "position", **loops}
            if rng.random() < 0.5:
                controller = {"type": "inverse_kinematics", "flex_compensation": True, "pretension": 3.0 * mass}
    return {
        "robot": robot,
        "simulation": {"backend": "reference", "duration": period, "control_step": period, "physics_step": 0.0005},
        "trajectory": {"type": "hold"},
        "controller": controller,
    }


def steps_of(loop):
    """Return the number of control steps in which an unstable loop grows by `DECADES`, with a margin for its start."""
    largest = np.abs(np.linalg.eigvals(loop.A)).max()
    return max(SHORTEST, math.ceil((DECADES + 2.0) * math.log(10.0) / abs(math.log(largest))))


def deviations(scenario, steps):
    """Return the largest deviation in each tenth of a pushed run from one that is not pushed; infinite at its end."""
    changes = {"simulation.duration": steps * scenario.simulation.control_step}
    runs = []
    for velocity in ([PUSH, -0.5 * PUSH, 0.7 * PUSH], [0.0, 0.0, 0.0]):
        try:
            runs.append(cdpr.simulate(scenario, overrides={**changes, "initial.velocity": velocity}))
        except SimulationStopped:
            return np.array([0.0, np.inf])
    moved = np.linalg.norm(runs[0].position - runs[1].position, axis=1)
    return np.array([part.max() for part in np.array_split(moved, 10)])


@pytest.mark.slow
def test_verdicts_of_random_loops():
    rng = np.random.default_rng(SEED)
    counts, wrong = dict.fromkeys(["stable", "unstable", "undamped", "undecided", "not computed", "too slow"], 0), []
    while sum(counts.values()) < LOOPS:
        data = random_loop(rng)
        try:
            scenario = cdpr.load_scenario(data)
        except CdprError:
            continue
        if list(faults(scenario)):
            continue
        try:
            loop = linearise(scenario, scenario.initial.state()[:7])
        except (NotLinearisedError, SimulationStopped):
            counts["not computed"] += 1
            continue
        found = verdict(loop)
        if found in (STABLE, UNSTABLE) and (steps := steps_of(loop)) > LONGEST:
            found = "too slow"
        counts[found] += 1
        if found not in (STABLE, UNSTABLE):
            continue
        moved = deviations(scenario, steps)
        grown = moved[-1] / moved[0] if moved[0] else np.inf
        bounded = moved.max() <= min(GROWN * moved[0], FAR) and moved[-1] <= moved[0]
        if (found == STABLE) != bool(bounded):
            wrong.append((found, grown, np.abs(np.linalg.eigvals(loop.A)).max(), data))
    print(counts)
    assert not wrong, f"{len(wrong)} of {counts}: {wrong[0]}"
