"""Controllers of teaching.md under noise, delay, a wrong mass, a broken cable and friction."""

from __future__ import annotations

from typing import Any

import numpy as np
from marked import table
from teaching_runs import Figures, number, results, simulate

from cdpr.log.run import Run


def motion_capture(**errors: Any) -> list[dict[str, Any]]:
    """Return sensors of pose and twist, both with these keys."""
    pose = {"position": {"noise": 0.0002}, "attitude": {"noise": 0.0005}}
    twist = {"velocity": {"noise": 0.005}, "turn_rate": {"noise": 0.01}}
    own = [pose, twist] if errors.pop("noise", False) else [{}, {}]
    return [{"type": kind, **errors, **each} for kind, each in zip(("pose", "twist"), own, strict=True)]


# Changes of caroca.yaml, and how the table names them.
PULLEY = {"type": "pulley", "radius": 0.1, "friction": 0.096}
BREAK = {"type": "cable_break", "time": 1.0, "cable": "cable_2", "detected_after": 0.01}
CASES: dict[str, tuple[str, dict[str, Any]]] = {
    "exact": ("exact", {}),
    "noise": ("noise", {"sensors": motion_capture(noise=True)}),
    "delay": ("delay of 10 ms", {"sensors": motion_capture(delay=0.01)}),
    "mass": ("mass 25 % too large", {"believed.platform.mass": 120}),
    "break": ("broken cable", {"events": [BREAK]}),
    "friction": ("friction of 20 %", {"robot.cable.exit": PULLEY}),
}
CONTROLLERS = ("computed_torque", "tension_feedback", "sliding_mode", "adaptive")
LOAD_CELLS = [{"type": "tension", "tension": {"noise": 0.5}}]
DELAYS = range(5, 100, 5)  # ms
CALM = 1.0  # mm: error at rest, below it a loop with a delay is calm
SHOWN_CASE = {**CASES["mass"][1]}


def changes_of(controller: str, case: str) -> dict[str, Any]:
    """Return the changes of a case, with load cells for the controller that needs them."""
    changes = {**CASES[case][1], "controller": {"type": controller}}
    if controller == "tension_feedback":
        changes["sensors"] = [*changes.get("sensors", []), *LOAD_CELLS]
    return changes


def errors(run: Run) -> Any:
    """Return the position errors (K,), mm."""
    return 1e3 * np.linalg.norm(run.position_error, axis=1)


def longest_delay(controller: str) -> int:
    """Return the longest of `DELAYS`, ms, with which the platform comes to rest at its target."""
    for delay in DELAYS:
        changes = changes_of(controller, "delay")
        run = simulate(
            "caroca.yaml", {**changes, "sensors": [*motion_capture(delay=delay / 1e3), *changes["sensors"][2:]]}
        )
        if not calm(run):
            return delay - DELAYS.step
    return DELAYS[-1]


def calm(run: Run) -> bool:
    """Return True if the platform rests at its target at the end of a run."""
    return run.status == "finished" and bool(errors(run)[-300:].max() <= CALM)


def controllers() -> Figures:
    """One move by four controllers in each case."""
    found: dict[str, dict[str, Any]] = {}
    for name in CONTROLLERS:
        runs = {case: simulate("caroca.yaml", changes_of(name, case)) for case in CASES}
        found[name] = {case: {"largest_mm": errors(run).max(), "end_mm": errors(run)[-1]} for case, run in runs.items()}
        found[name]["change_N"] = {case: rough(runs[case]) for case in ("exact", "noise")}
        found[name]["delay_ms"] = longest_delay(name)
    return found


def rough(run: Run) -> float:
    """Return the root mean square of the changes of all tensions from one control step to the next, N."""
    return float(np.sqrt(np.mean(np.diff(run.tension, axis=0) ** 2)))


def error_table() -> str:
    """Largest error of each controller in each case, and the error at the end."""
    rows = [
        [f"`{name}`", *(f"{number(row[case]['largest_mm'])} / {number(row[case]['end_mm'])}" for case in CASES)]
        for name, row in results()["controllers"].items()
    ]
    return table(["position error, largest / at the end (mm)", *(title for title, _ in CASES.values())], rows)


def cost_table() -> str:
    """Changes of the tensions, and the longest delay of each controller."""
    rows = [
        [f"`{name}`", number(row["change_N"]["exact"]), number(row["change_N"]["noise"]), str(row["delay_ms"])]
        for name, row in results()["controllers"].items()
    ]
    titles = ["controller", "change of the tensions in 1 ms, exact (N, rms)", "with noise (N, rms)"]
    return table([*titles, "longest delay without oscillation (ms)"], rows)
