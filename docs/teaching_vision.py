"""Visual servoing of teaching.md in the cases of the other controllers, on a move in view of its camera."""

from __future__ import annotations

from typing import Any

from marked import table
from teaching_controllers import CASES, calm, errors, rough
from teaching_runs import Figures, number, results, simulate

SCENARIO = "visual_servo.yaml"
SENSORS = {"computed_torque": "motion capture", "visual_servo": "camera"}
NOISE = 0.2  # px, standard deviation of an image point
DELAYS = range(10, 200, 10)  # ms


def changes_of(controller: str, case: str, delay: float = 0.0) -> dict[str, Any]:
    """Return the changes of a case; the camera has no other errors than those of the case. `delay` is in s."""
    changes: dict[str, Any] = dict(CASES[case][1])
    delay = 0.01 if case == "delay" and not delay else delay
    if controller == "computed_torque":
        sensors = [{**each, "delay": delay} for each in changes.get("sensors", [])]
        return {**changes, "sensors": sensors, "controller": {"type": controller}}
    changes.pop("sensors", None)
    return {**changes, "sensors.0.delay": delay, "sensors.0.pixel.noise": NOISE if case == "noise" else 0.0}


SHOWN_CASE = changes_of("visual_servo", "mass")


def longest_delay(controller: str) -> int:
    """Return the longest of `DELAYS`, ms, with which the platform comes to rest at its target."""
    for delay in DELAYS:
        if not calm(simulate(SCENARIO, changes_of(controller, "delay", delay / 1e3))):
            return delay - DELAYS.step
    return DELAYS[-1]


def vision() -> Figures:
    """One move by both controllers in each case."""
    found: dict[str, dict[str, Any]] = {}
    for name in SENSORS:
        runs = {case: simulate(SCENARIO, changes_of(name, case)) for case in CASES}
        found[name] = {case: {"largest_mm": errors(run).max(), "end_mm": errors(run)[-1]} for case, run in runs.items()}
        found[name]["change_N"] = {case: rough(runs[case]) for case in ("exact", "noise")}
        found[name]["delay_ms"] = longest_delay(name)
    return found


def vision_table() -> str:
    """Errors and costs of both controllers: a row for each figure."""
    found = results()["vision"]
    rows = [
        [f"position error: {title} (mm)", *(_pair(found[name][case]) for name in SENSORS)]
        for case, (title, _) in CASES.items()
    ]
    for case in ("exact", "noise"):
        rows.append([f"change of the tensions in 2 ms: {case} (N, rms)"])
        rows[-1] += [number(found[name]["change_N"][case]) for name in SENSORS]
    rows.append(["longest delay without oscillation (ms)", *(str(found[name]["delay_ms"]) for name in SENSORS)])
    return table(
        ["largest error / error at the end", *(f"`{name}`, {sensor}" for name, sensor in SENSORS.items())], rows
    )


def _pair(row: Figures) -> str:
    return f"{number(row['largest_mm'])} / {number(row['end_mm'])}"
