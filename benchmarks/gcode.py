"""Cost of a G-code file of 100 000 moves: CPU seconds from `load_scenario` to the planned motion, and memory."""

from __future__ import annotations

import json
import math
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from cdpr.gcode import Course, follow, lines
from cdpr.gcode import arcs as arcs_of
from cdpr.trajectory import Limits

MOVES = 100_000
REPEATS = 3
TURN = 2.0 * math.pi
RADII = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0)  # m
CHORDS = (1e-4, 3e-4, 1e-3, 2e-3, 5e-3)  # m
TOLERANCES = (1e-5, 2e-5, 5e-5, 1e-4, 1e-3, 5e-3)  # m
MISSED = 1.0 / 1.3
LIMITS = (Limits(1.0, 2.0, 20.0), Limits(0.5, 1.0, 3.0), Limits(2.0, 20.0, 2000.0))
ROBOT = Path(__file__).parent.parent / "scenarios" / "robots" / "caroca.yaml"
SCENARIO = """
robot: robot.yaml
simulation: {{duration: 1.0}}
initial: {{position: [0, 0, 1.2]}}
trajectory:
  type: gcode
  file: {file}
  tolerance: {tolerance}
  limits: {{velocity: 1.0, acceleration: 2.0, jerk: 20}}
controller: {{type: computed_torque, kp: 100, kd: 20}}
solver: {{type: qp}}
"""
LOAD = """
import json, resource, sys
from time import process_time
from cdpr.scenario import load_scenario
def load(name):
    start = process_time()
    end = load_scenario(name).planned.end
    return process_time() - start, end
load(sys.argv[1])
seconds, end = load(sys.argv[2])
print(json.dumps([seconds, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024, end]))
"""


def spiral() -> Iterator[str]:
    """Chords of 1 mm on a spiral."""
    angle = 0.0
    for _ in range(MOVES - 1):
        radius = 50.0 + 0.5 * angle / math.pi
        angle += 1.0 / radius
        yield f"G1 X{radius * math.cos(angle):.3f} Y{radius * math.sin(angle):.3f}"


def slices() -> Iterator[str]:
    """Layers of a wavy outline in chords of 2 mm, and a zigzag of long lines inside."""
    done, height = 0, 1200.0
    while done < MOVES - 1:
        height += 0.2
        yield f"G1 Z{height:.2f}"
        for k in range(600):
            turn = 2 * math.pi * k / 600
            radius = 200 + 20 * math.sin(9 * turn)
            yield f"G1 X{radius * math.cos(turn):.3f} Y{radius * math.sin(turn):.3f}"
        for k in range(100):
            yield f"G1 X{-100 if k % 4 in (0, 3) else 100} Y{-100 + 2 * (k // 2)}"
        done += 701


def corners() -> Iterator[str]:
    """Right angles of lines of 20 mm."""
    for k in range(MOVES - 1):
        yield f"G1 {'XY'[k % 2]}{20 * (k % 4 // 2 + 1)}"


def arcs() -> Iterator[str]:
    """Arcs of 2 mm that turn to one side and the other, there and back."""
    yield "G91"
    for k in range(MOVES - 2):
        yield f"G{2 + k % 2} X{2 if k // 400 % 2 else -2} R10"


KINDS = {"spiral": spiral, "slices": slices, "corners": corners, "arcs": arcs}


def loaded(lines: Iterator[str], tolerance: float) -> list[float]:
    """CPU seconds, MiB of the whole process, and how long the motion lasts, s; the fastest of several loads."""
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        shutil.copy(ROBOT, place / "robot.yaml")
        (place / "few.ngc").write_text("F6000\nG1 X10\nX20 Y1\nX30 Y0\nG3 X0 Y0 R100\n")
        (place / "many.ngc").write_text("\n".join(["F6000", "G1 X0 Y0 Z1200", *lines][: MOVES + 1]) + "\n")
        for name in ("few", "many"):
            text = SCENARIO.format(file=f"{name}.ngc", tolerance=tolerance)
            (place / f"{name}.yaml").write_text(text)
        words = [sys.executable, "-c", LOAD, str(place / "few.yaml"), str(place / "many.yaml")]
        found = [
            json.loads(subprocess.run(words, check=True, stdout=subprocess.PIPE, text=True).stdout)
            for _ in range(REPEATS)
        ]
    return min(found)


def turn(radius: float, chord: float | None, tolerance: float, limits: Limits) -> float:
    """Seconds of a whole turn, m, as an arc or in chords."""
    if chord is None:
        unit = np.eye(3)[:, None]
        pieces = arcs_of(
            np.zeros((1, 3)), unit[0], unit[1], np.full((1, 2), radius), np.array([TURN]), np.zeros((1, 3))
        )
    else:
        angle = np.linspace(0.0, TURN, max(round(TURN * radius / chord), 2) + 1)
        points = np.round(np.stack([radius * np.cos(angle), radius * np.sin(angle), 0.0 * angle], axis=1), 6)
        pieces = lines(points[:-1], points[1:])
    count = len(pieces)
    fast, never = np.full(count, limits.velocity), np.zeros(count, dtype=bool)
    course = Course(pieces, fast, np.full(count, tolerance), never, np.zeros(count))
    return follow(0.0, course, limits, np.array([1.0, 0.0, 0.0, 0.0])).end


def turns() -> dict[str, float]:
    """The largest share over all limits and radii, of chords that miss no more than MISSED of the tolerance."""
    shares = {}
    for tolerance in TOLERANCES:
        for chord in CHORDS:
            found = [
                turn(radius, chord, tolerance, limits) / turn(radius, None, 0.0, limits)
                for limits in LIMITS
                for radius in RADII
                if chord <= 0.5 * radius and radius <= 3000 * chord and chord**2 / 8 / radius <= MISSED * tolerance
            ]
            if found:
                shares[f"{1e3 * chord:g} mm within {1e3 * tolerance:g} mm"] = max(found)
    return shares


def measure() -> dict[str, dict[str, float]]:
    """All figures, by kind and tolerance."""
    result = {}
    for name, kind in KINDS.items():
        for tolerance in (0.0, 1e-3):
            seconds, mebibytes, end = loaded(kind(), tolerance)
            result[f"{name}, {tolerance:g} m"] = {"CPU s": seconds, "MiB": mebibytes, "motion": end}
    result["turns"] = turns()
    return result


if __name__ == "__main__":
    figures = measure()
    if "--json" in sys.argv:
        print(json.dumps(figures, indent=1))
    else:
        for name, found in figures.items():
            print(f"{name}: " + ", ".join(f"{key} {value:.4g}" for key, value in found.items()))
