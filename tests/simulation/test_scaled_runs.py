"""Similar robots, scaled in length and force at the same gravity: every figure scales according to its dimension.

CDPR_SCALES sets the number of further random scales. Scales are powers of two, of length even ones, so that scaled
numbers differ by no round-off: any difference is an absolute number in the program.
"""

from __future__ import annotations

import json
import os

import numpy as np
import pytest
from command_line import cdpr_here

SCALES = [(-12, -30), (8, 17)]  # binary logarithms: 4 m to 1 mm and 1 km, 900 N to 1e-6 N and 1e8 N
_RNG = np.random.default_rng(4)
SCALES += [
    (2 * int(_RNG.integers(-6, 5)), int(_RNG.integers(-30, 18))) for _ in range(int(os.environ.get("CDPR_SCALES", "0")))
]

SAME = 1e-9  # relative: sums of a few thousand samples
POLES = 1e-8  # relative: forces and moments scale apart, so the wrench matrix is reduced in another order, and six of
# these poles are nearly equal: differences of 7e-14 in the map of a period, whose steps scale, are 8e-10 of a pole
ROUND_OFF = 1e-9  # N, J, m, rad of the robot that is not scaled: a figure below it is round-off itself

# Exponents of length, force and time by the end of a figure's name; without any it has no dimension.
UNITS = {
    "_N_per_m": (-1, 1, 0),
    "_N_m": (1, 1, 0),
    "_m_per_s2": (1, 0, -2),
    "_m_per_s": (1, 0, -1),
    "_rad_per_s2": (0, 0, -2),
    "_rad_per_s": (0, 0, -1),
    "_kg_m2": (1, 1, 2),
    "_kg": (-1, 1, 2),
    "_per_s": (0, 0, -1),
    "_Hz": (0, 0, -1),
    "_W": (1, 1, -1),
    "_J": (1, 1, 0),
    "_N": (0, 1, 0),
    "_s": (0, 0, 1),
    "_m": (1, 0, 0),
    "volume": (3, 0, 0),
    "bounds": (1, 0, 0),
    "box": (1, 0, 0),
    "clearance": (1, 0, 0),
    "value": (0, 1, 0),
}
OTHERWISE = ("folder", "by", "name", "real_time_factor", "static_wrench", "clearance_min_at_s")  # of a hold any time


def scaled(values, length=0, force=0, time=0, *, scale):
    """Return numbers of a dimension at a scale (length, force), the time being the square root of the length."""
    return (np.array(values) * scale[0] ** length * scale[1] ** force * scale[0] ** (time / 2)).tolist()


def written(folder, scale, motion):
    """Write a robot of 4 m and 20 kg and a scenario, scaled; return their path."""

    def to(values, length=0, force=0, time=0):
        return scaled(values, length, force, time, scale=scale)

    cables = [
        {"frame": to([2 * a, 1.5 * b, 1.25 + 1.25 * c], 1), "platform": to([-0.2 * a, 0.15 * b * c, -0.1 * c], 1)}
        for c in (1, -1)
        for a in (-1, 1)
        for b in (-1, 1)
    ]
    robot = {
        "platform": {"mass": to(20, -1, 1, 2), "inertia": to([0.2, 0.3, 0.4, 0, 0, 0], 1, 1, 2)},
        "tension": {"min": to(10, 0, 1), "max": to(900, 0, 1)},
        "home": {"position": to([0, 0, 1.25], 1)},
        "cable": {"diameter": to(0.002, 1), "exit": {"type": "pulley", "radius": to(0.05, 1), "axis": [0, 0, -1]}},
        "cables": cables,
    }
    target = {"position": to([0.2, 0.1, 1.4], 1), "orientation": {"rpy": [0, 0, 0.1]}}
    moves = {"type": "quintic", "duration": to(0.3, 0, 0, 1), "to": target}
    data = {
        "robot": robot,
        "simulation": {key: to(value, 0, 0, 1) for key, value in (("duration", 0.4), ("control_step", 0.002))},
        "initial": {"position": to([0.1, -0.1, 1.2], 1)},
        "trajectory": moves if motion else {"type": "hold"},
        "controller": {"type": "computed_torque", "kp": to(50, 0, 0, -2), "kd": to(14, 0, 0, -1)},
    }
    data["simulation"]["physics_step"] = data["simulation"]["control_step"]
    folder.mkdir()
    (folder / "s.yaml").write_text(json.dumps(data))
    return folder / "s.yaml"


def figures(node, unit=(0, 0, 0), path=""):
    """Yield path, dimension and value of every figure in JSON data."""
    if isinstance(node, dict):
        for key, value in node.items():
            if key not in OTHERWISE:
                found = next((UNITS[end] for end in UNITS if key.endswith(end)), unit)
                within = UNITS["clearance"] if path.endswith("clearance") and key == "value" else found
                yield from figures(value, within, f"{path}.{key}")
    elif isinstance(node, list):
        for i, value in enumerate(node):
            yield from figures(value, unit, f"{path}[{i}]")
    else:
        yield path, unit, node


def told(path, *, motion):
    """Return the figures of commands at this scenario, by path."""
    asked = {"run": ("run", path, "--no-report", "--out", path.parent / "out")}
    if motion:
        asked |= {"info": ("info", path), "size": ("size", path), "w": ("workspace", "static", path, "--cells", "4")}
    done = {name: json.loads(cdpr_here(*arguments, "--json").stdout) for name, arguments in asked.items()}
    return {where: (unit, value) for where, unit, value in figures(done)}


@pytest.mark.parametrize("motion", [True, False], ids=["move", "hold"])
def test_figures_are_in_proportion(tmp_path, motion):
    one = told(written(tmp_path / "one", (1.0, 1.0), motion), motion=motion)
    assert len(one) > (200 if motion else 20)
    for i, powers in enumerate(SCALES):
        scale = tuple(2.0**power for power in powers)
        other = told(written(tmp_path / f"other_{i}", scale, motion), motion=motion)
        assert other.keys() == one.keys()
        for path, (unit, value) in one.items():
            found = other[path][1]
            if isinstance(value, bool) or not isinstance(value, int | float):
                assert found == value, (path, powers)
            else:
                same = POLES if ".poles[" in path else SAME
                assert found / scaled(1.0, *unit, scale=scale) == pytest.approx(value, rel=same, abs=ROUND_OFF), (
                    path,
                    powers,
                )
