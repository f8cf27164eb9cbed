"""Measure the instructions of exported control steps, and write the table of docs/realtime.md.

Run: python benchmarks/realtime.py (needs g++ and valgrind)

Each step of a program is counted by `valgrind --tool=callgrind`. Usual steps follow the motion of the scenario; hard
ones have large errors and accelerations, so that limits are active or the wrench is infeasible.
"""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

import cdpr
from cdpr.base.errors import CdprError
from cdpr.formats.write.native import write_native
from cdpr.native.rotations import from_rotation_vector, multiply

ROOT = Path(__file__).parent.parent
FILE = Path(__file__).parent / "realtime.json"
PAGE = ROOT / "docs" / "realtime.md"
sys.path.append(str(ROOT / "docs"))
from marked import rewritten, table  # noqa: E402

ROBOTS = ("planar", "caroca", "cogiro_pulleys", "twelve")
USUAL, HARD = 10, 50
MAIN = """
#define CDPR_IMPLEMENTATION
#include "robot.h"
#include <stdio.h>
static cdpr_robot robot;
static unsigned char numbers[CDPR_FILE_BYTES];
int main() {
    FILE* file = fopen("robot.bin", "rb");
    const size_t bytes = fread(numbers, 1, sizeof numbers, file);
    if (cdpr_begin(&robot, numbers, bytes)) return 1;
    FILE* cases = fopen("cases", "rb");
    double c[1 + CDPR_STATE + CDPR_DESIRED], tensions[CDPR_CABLES];
    while (fread(c, sizeof c, 1, cases) == 1) printf("%d\\n", cdpr_step(&robot, c[0], c + 1, c + 14, tensions));
}
"""


def cases(scenario: cdpr.Scenario, rng: np.random.Generator) -> np.ndarray:
    """Return (USUAL + HARD, 33): time, state, desired motion."""
    rows = []
    dof = np.isin(["x", "y", "z", "rx", "ry", "rz"], scenario.robot.dof)
    for k in range(USUAL + HARD):
        time = rng.uniform(0.0, scenario.simulation.duration)
        desired = scenario.desired.sample(time)
        state = desired[:13].copy()
        if k >= USUAL:
            turn = np.where(dof[3:], rng.normal(0.0, 0.3, 3), 0.0)
            state[:3] += np.where(dof[:3], rng.normal(0.0, 0.3, 3), 0.0)
            state[3:7] = multiply(state[3:7], from_rotation_vector(turn))
            desired[13:] += np.where(dof, rng.normal(0.0, 1.0, 6) * 10.0 ** rng.uniform(-1.0, 4.0), 0.0)
        rows.append(np.concatenate([[time], state, desired]))
    return np.array(rows)


def measure(scenario: cdpr.Scenario, folder: Path) -> dict[str, int]:
    """Return the most instructions of a usual and of a hard step, and how many of the hard ones were replaced."""
    write_native(scenario, folder)
    (folder / "main.cpp").write_text(MAIN)
    cases(scenario, np.random.default_rng(1)).tofile(folder / "cases")
    subprocess.run(["g++", "-std=c++17", "-O2", "-ffp-contract=off", "main.cpp", "-o", "main"], cwd=folder, check=True)
    count = ["--tool=callgrind", "--toggle-collect=cdpr_step", "--dump-after=cdpr_step", "--callgrind-out-file=count"]
    command = ["valgrind", "-q", *count, "./main"]
    done = subprocess.run(command, cwd=folder, check=True, capture_output=True, text=True)
    found = [
        int(re.search(r"^(?:summary|totals): (\d+)", (folder / f"count.{k + 1}").read_text(), re.MULTILINE)[1])
        for k in range(USUAL + HARD)
    ]
    replaced = sum(int(line) > 0 for line in done.stdout.split()[USUAL:])
    return {"usual": max(found[:USUAL]), "hard": max(found[USUAL:]), "replaced": replaced}


def solvers() -> list[str]:
    """Return the solvers that can be exported."""
    from cdpr.formats.write.native import native_files
    from cdpr.plugins.registry import registry

    names = []
    for name in sorted(registry().names("solver")):
        try:
            native_files(load("planar", name))
        except CdprError:
            continue
        names.append(name)
    return names


def load(robot: str, solver: str) -> cdpr.Scenario:
    """Return the scenario of a robot with a solver."""
    changes = [f"solver={{type: {solver}, infeasible: best_effort}}"]
    if robot == "twelve":
        robot = "caroca"
        changes.append("robot=robots/twelve.yaml")
    return cdpr.load_scenario(ROOT / "scenarios" / f"{robot}.yaml", overrides=changes)


def instructions() -> str:
    """Return the table of what was measured."""
    found = json.loads(FILE.read_text())
    rows = []
    for solver, robots in found.items():
        cells = [f"{e['usual']:,} / {e['hard']:,}".replace(",", " ") if (e := robots.get(r)) else "-" for r in ROBOTS]
        rows.append([f"`{solver}`", *cells])
    return table(["solver", *(f"`{robot}`" for robot in ROBOTS)], rows)


def main() -> None:
    """Measure and write."""
    for name in ("g++", "valgrind"):
        if not shutil.which(name):
            sys.exit(f"{name} not found; install it (Debian: apt-get install {name})")
    found: dict[str, dict[str, dict[str, int]]] = {}
    for solver in solvers():
        for robot in ROBOTS:
            try:
                with tempfile.TemporaryDirectory() as folder:
                    counted = measure(load(robot, solver), Path(folder))
            except CdprError as error:
                print(robot, solver, error)
                continue
            print(robot, solver, counted, flush=True)
            found.setdefault(solver, {})[robot] = counted
    FILE.write_text(json.dumps(found, indent=1) + "\n")
    PAGE.write_text(rewritten(PAGE.read_text(), {"instructions": instructions}))


if __name__ == "__main__":
    main()
