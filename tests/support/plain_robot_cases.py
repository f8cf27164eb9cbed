"""Robots of other Python programs for tests: CDPyR in JSON, YAML and XML, and lists of anchors."""

from __future__ import annotations

import json
import math

FRAME = [[-1, 0.95, 1.05], [1.05, 0.95, 1], [1.05, -1, 0.95], [-0.95, -1.05, 1]]
PLATFORM = [[-0.095, 0.105, 0.1], [0.105, 0.095, 0.1], [0.105, -0.1, 0.095], [-0.1, -0.095, 0.105]]
QUARTER = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]  # about z
TILTED = [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]  # its z axis is -y of the world


def cdpyr_robot():
    """A robot as CDPyR dumps it: tuples as lists, and null for what is not set."""
    return {
        "name": "Sample 3R3T robot",
        "gravity": [0.0, 0.0, -9.81],
        "frame": {
            "anchors": [
                {
                    "position": point,
                    "dcm": TILTED if k == 1 else QUARTER,
                    "pulley": {"radius": 0.1, "inertia": None, "dcm": None} if k == 1 else None,
                    "drivetrain": None,
                }
                for k, point in enumerate(FRAME)
            ]
        },
        "platforms": [
            {
                "name": "platform",
                "anchors": [{"position": point, "dcm": None} for point in PLATFORM],
                "pose": {"time": None, "linear": {"position": [0.1, 0.2, 0.3]}, "angular": {"dcm": QUARTER}},
                "motion_pattern": {"translation": 3, "rotation": 3},
                "center_of_gravity": [0.0, 0.0, 0.02],
                "inertia": {
                    "linear": [[5.0, 0, 0], [0, 5.0, 0], [0, 0, 5.0]],
                    "angular": [[0.3, 0.01, 0], [0.01, 0.4, 0], [0, 0, 0.5]],
                },
            }
        ],
        "cables": [
            {
                "name": "Dyneema",
                "material": "Liros D-Pro SK78",
                "diameter": 0.006,
                "modulus": {"elasticities": [2e9], "viscosities": None},
                "color": "red",
                "breaking_load": load,
                "density": math.inf,
            }
            for load in (1000.0, 2000.0)
        ],
        "kinematic_chains": [
            {"frame_anchor": k, "platform": 0, "platform_anchor": 3 - k, "cable": k % 2} for k in range(4)
        ],
    }


def as_xml(value, name="robot"):
    """The text that xmltodict makes of a dictionary: a list becomes elements of one name, a tuple in it a text."""
    if isinstance(value, dict):
        return f"<{name}>" + "\n".join(as_xml(inner, key) for key, inner in value.items()) + f"</{name}>"
    if isinstance(value, list):
        return "".join(as_xml(tuple(item) if isinstance(item, list) else item, name) for item in value)
    return f"<{name}>{'' if value is None else value}</{name}>"


def anchor_list(**changes):
    """A list of anchors in JSON with tabs."""
    robot = {
        "name": "tabletop-light-4cable",
        "n_cables": 4,
        "dof": 3,
        "anchors": [[0.3, 0.3, 0.4], [-0.3, 0.3, 0.4], [-0.3, -0.3, 0.4], [0.3, -0.3, 0.4]],
        "attachments": [[0.0, 0.0, 0.0]] * 4,
        "mass": 0.2,
        "inertia": [[1e-4, 0, 0], [0, 1e-4, 0], [0, 0, 1e-4]],
        "com": [0.0, 0.0, 0.0],
        "t_min": 0.5,
        "t_max": 50.0,
        "cable_diameter_m": 0.001,
    } | changes
    return json.dumps({key: value for key, value in robot.items() if value is not None}, indent="\t")
