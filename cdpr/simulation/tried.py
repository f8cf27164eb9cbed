"""New scenarios that were tried: gains and steps with which the robot's cables do not swing up."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from time import process_time

import numpy as np

from cdpr import defaults
from cdpr.errors import Interrupted, SimulationStopped
from cdpr.log.run import Run
from cdpr.model import Robot
from cdpr.plugins.registry import registry
from cdpr.scenario import Scenario, load_scenario
from cdpr.scenario.template import Sizes, scenario_text
from cdpr.simulation.prepare import faults
from cdpr.simulation.simulate import simulate

HALVINGS = 7  # of the bandwidth: from the defaults down to that of a slow crane
STEPS = (0.001, 0.0005, 0.00025, 0.0001, 0.00005, 0.00002)  # s, physics steps that are tried
BUDGET = 10.0  # s of CPU time for all trials: the window waits for them
LONGER = 2.0  # times the duration that is written, in which slow growth shows
LARGEST = 0.05  # of the frame's extent: errors beyond are no control
GROWTH = 1.02  # of errors and swings of tensions from one part of the rest to the next; a loop that settles is below 1
RESOLVED = 1e-6  # of the frame's extent and of the highest tension: growth of less is not judged


@dataclass(frozen=True)
class Tried:
    """The text of a scenario, and what is to be said of it; `stable` tells whether its loop is."""

    text: str
    note: str
    stable: bool


def tried_scenario(file: str, source: str | None, sizes: Sizes) -> Tried:
    """Return a new scenario, as `scenario_text` writes it, with gains that were tried in memory.

    The default gains are kept where they are stable. Otherwise the bandwidth is halved: with elastic cables the
    platform is moved through drums and springs, and fast feedback feeds their vibration.
    """
    plain = scenario_text(file, source, sizes)
    scenario = load_scenario(file, text=plain)
    if scenario.ideal_cables:
        return Tried(plain, "", True)
    best: tuple[float, str] | None = None
    step = next((step for step in STEPS if _fits(scenario, step)), None)
    if step is None:
        note = f"warning: these cables need physics steps below {STEPS[-1]:g} s: {_reasons(scenario)}"
        return Tried(plain, note, False)
    end = process_time() + BUDGET
    for changes in _candidates(scenario, step):
        text = scenario_text(file, source, sizes, changes)
        try:
            error, stable = _try(load_scenario(file, text=text), end)
        except Interrupted:
            note = f"warning: not tried to the end: the trials of gains reached their limit of {BUDGET:g} s of CPU time"
            return Tried(best[1] if best else text, f"{note}; check the errors of the first run", False)
        if stable:
            said = ", ".join(f"{key.rpartition('.')[2]} {value:g}" for key, value in changes.items())
            note = f"tried: stable with {said}, errors up to {1e3 * error:.3g} mm" if changes else ""
            return Tried(text, note, True)
        if best is None or error < best[0]:
            best = error, text
    assert best is not None
    return Tried(best[1], f"warning: no stable gains were found for these elastic cables: {_remedy(scenario)}", False)


def _candidates(scenario: Scenario, step: float) -> Iterator[dict[str, float]]:
    """Yield changes of gains, the mildest first, with this physics step, s."""
    options = registry().get("controller", defaults.CONTROLLER).info.options().model_dump()
    steps = {} if step == scenario.simulation.physics_step else {"simulation.physics_step": step}
    for halving in range(HALVINGS):
        share = 0.5**halving
        gains = {"controller.kp": options["kp"] * share**2, "controller.kd": options["kd"] * share}
        yield steps | (gains if halving else {})


def _fits(scenario: Scenario, step: float) -> bool:
    """Return whether a physics step is short enough for the cables."""
    return not list(faults(scenario.with_changes({"simulation.physics_step": step})))


def _reasons(scenario: Scenario) -> str:
    """Return why the shortest step is too long."""
    found = faults(scenario.with_changes({"simulation.physics_step": STEPS[-1]}))
    return "; ".join(str(fault.error) for fault in found)


def _try(scenario: Scenario, end: float) -> tuple[float, bool]:
    """Return the largest error, m, in a longer run than the scenario's, and whether its loop is stable.

    Raises Interrupted when the CPU time, s, reaches `end`; a run looks at it every half second.
    """

    def check(done: int, total: int) -> None:
        if process_time() > end:
            raise Interrupted

    longer = {"simulation.duration": LONGER * scenario.simulation.duration}
    try:
        run = simulate(scenario, overrides=longer, progress=check)
    except Interrupted:
        raise
    except SimulationStopped:
        return np.inf, False
    return float(run.summary()["position_error_m"]["max"]), _settles(run, scenario.robot)


def _settles(run: Run, robot: Robot) -> bool:
    """Return whether errors stay small and do not grow, and the cables' tensions are neither zero nor too large."""
    figures = run.summary()
    if figures["slack_samples"] or figures["beyond_limits_steps"]["tension_above_max"]:
        return False
    extent = float(np.linalg.norm(np.ptp(robot.anchors[:, :3], axis=0)))
    error = np.hypot(
        np.linalg.norm(run.position_error, axis=1),
        robot.characteristic_length * np.linalg.norm(run.orientation_error, axis=1),
    )
    half = len(error) // 2
    before, after = (float(part.max()) for part in np.array_split(error[half:], 2))
    swings = [float(np.ptp(part, axis=0).max()) for part in np.array_split(run.cable_tension[half:], 2)]
    if swings[1] > max(GROWTH * swings[0], RESOLVED * float(robot.tension_max.max())):
        return False
    return bool(error.max() <= LARGEST * extent and after <= max(GROWTH * before, RESOLVED * extent))


def _remedy(scenario: Scenario) -> str:
    if all(not cable.damping for cable in scenario.robot.cables):
        return "they have no damping; give robot.cable.damping (N s/m), or friction to robot.winch"
    return "give more robot.cable.damping (N s/m), stiffer cables, or friction to robot.winch"
