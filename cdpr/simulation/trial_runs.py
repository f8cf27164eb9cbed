"""Trial runs of new scenarios: gains and steps with stable loops."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from time import process_time

import numpy as np

from cdpr.base.errors import CdprError, Interrupted, SimulationStopped
from cdpr.log.run import Run
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.scenario import Scenario, load_scenario
from cdpr.scenario.template import Sizes, scenario_text
from cdpr.simulation.build import faults
from cdpr.simulation.linearised import decay_rate
from cdpr.simulation.linearised_scenario import NotLinearisedError
from cdpr.simulation.whole_run import simulate

HALVINGS = 7  # of the bandwidth: from the defaults down to that of a slow crane
DOUBLINGS = 4  # of the pretension, for controllers without gains
STEPS = (0.001, 0.0005, 0.00025, 0.0001, 0.00005, 0.00002)  # s, candidate physics steps
DECAY = 1e-3  # 1/s, required of the slowest mode: a thousand times the error of the linearisation
NEUTRAL = -1e-3  # 1/s, required with fewer cables than degrees of freedom: such a platform swings freely
LONGER = 2.0  # times the written duration: a run that confirms the linearisation
LARGEST = 0.05  # of the frame's extent: larger errors mean loss of control
GROWTH = 1.02  # of errors and tension oscillations between parts of the final rest; below 1 for a loop that settles
RESOLVED = 1e-6  # of the frame's extent and of the highest tension: smaller growth is ignored
WARNING = "warning: "  # indent of notes on problems
BUDGET = 10.0  # s of CPU time for all trials: the window waits for them


@dataclass(frozen=True)
class Trial:
    """Text of a scenario and a note on its trial; `stable` is True for a stable loop."""

    text: str
    note: str
    stable: bool


def scenario_with_trials(file: str, source: str | None, sizes: Sizes) -> Trial:
    """Return a new scenario, as `scenario_text` writes it, with gains from trials in memory.

    The default gains are kept if they are stable. Otherwise the bandwidth is halved: with elastic cables, drums and
    springs move the platform, and fast feedback excites their vibration. A loop is stable if all modes of its
    linearisation decay, at start and goal, and a longer run confirms it.
    """
    plain = scenario_text(file, source, sizes)
    scenario = load_scenario(file, text=plain)
    if scenario.ideal_cables:
        problem = _problem(scenario)
        return Trial(plain, f"{WARNING}this scenario was tried: {problem}" if problem else "", not problem)
    step = next((step for step in STEPS if _fits(scenario, step)), None)
    if step is None:
        note = f"{WARNING}these cables need physics steps below {STEPS[-1]:g} s: {_reasons(scenario)}"
        return Trial(plain, note, False)
    required = DECAY if scenario.robot.m >= scenario.robot.n else NEUTRAL
    _slowest(scenario.with_changes({"simulation.physics_step": step}))  # includes first-call costs
    end = process_time() + BUDGET
    best, best_text, best_note = -np.inf, plain, ""
    for changes in _candidates(scenario, step):
        text = scenario_text(file, source, sizes, changes)
        candidate = load_scenario(file, text=text)
        rate = _slowest(candidate)
        if rate >= required:
            try:
                error, stable = _try(candidate, end)
            except Interrupted:
                return Trial(text, _unfinished(), False)
            if stable:
                gains = ", ".join(f"{key.rpartition('.')[2]} {value:g}" for key, value in changes.items())
                note = f"tried: stable with {gains}, errors up to {1e3 * error:.3g} mm" if changes else ""
                return Trial(text, note, True)
        if rate > best:
            best, best_text, best_note = rate, text, _grown(rate)
        if process_time() > end:
            return Trial(best_text, _unfinished(), False)
    options = scenario.controller_options.model_dump()
    varied = "gains were" if "kp" in options else "pretension was"
    note = f"{WARNING}no stable {varied} found for these elastic cables{best_note}: {_remedy(scenario)}"
    if options.get("pretension") == 0.0 and scenario.robot.m > scenario.robot.n:
        note = (
            f"{WARNING}the loop is not stable without pretension, and none was tried, as the robot's tension.min is 0: "
            "set it above 0 in the robot file (cdpr import --tension MIN,MAX), and write the scenario again"
        )
    return Trial(best_text, note, False)


def _slowest(scenario: Scenario) -> float:
    """Return the decay rate (1/s) of the slowest mode at start and goal; minus infinity if there is none."""
    desired = np.zeros(19)
    scenario.desired.sampler(desired)(scenario.simulation.duration)
    poses: list[Array] = [scenario.initial.state()[:7]]
    if not np.array_equal(poses[0], desired[:7]):
        poses.append(desired[:7])
    try:
        return min(decay_rate(scenario, pose) for pose in poses)
    except (SimulationStopped, NotLinearisedError):
        return -np.inf


def _unfinished() -> str:
    """Return the note on trials that took too long."""
    text = f"not tried to the end: the trials of gains reached their limit of {BUDGET:g} s of CPU time"
    return f"{WARNING}{text}; check the errors of the first run"


def _grown(rate: float) -> str:
    """Return the note on the behaviour of the best gains."""
    if not np.isfinite(rate) or rate >= DECAY:
        return ""
    return f" (with those written a vibration {'grows' if rate < 0.0 else 'decays'} by {abs(rate):.2g} 1/s)"


def _problem(scenario: Scenario) -> str:
    """Return the problem of a run of a scenario with ideal cables; "" if there is none."""
    try:
        run = simulate(scenario)
    except CdprError as error:
        return str(error)
    figures = run.summary()
    largest = float(figures["position_error_m"]["max"])
    if largest > LARGEST * _extent(scenario.robot):
        return f"position errors reach {largest:.3g} m; change controller.kp, controller.kd or the trajectory"
    return ""


def _candidates(scenario: Scenario, step: float) -> Iterator[dict[str, float]]:
    """Yield changes of gains, or of the pretension without them, the mildest first, with this physics step, s."""
    options = scenario.controller_options.model_dump()
    steps = {} if step == scenario.simulation.physics_step else {"simulation.physics_step": step}
    yield steps
    if "kp" in options:
        for share in (0.5**halving for halving in range(1, HALVINGS)):
            yield steps | {"controller.kp": options["kp"] * share**2, "controller.kd": options["kd"] * share}
    elif options.get("pretension"):
        for doubling in range(1, DOUBLINGS):
            yield steps | {"controller.pretension": options["pretension"] * 2.0**doubling}


def _fits(scenario: Scenario, step: float) -> bool:
    """Return whether a physics step is short enough for the cables."""
    return not list(faults(scenario.with_changes({"simulation.physics_step": step})))


def _reasons(scenario: Scenario) -> str:
    """Return the reason why the shortest step is too long."""
    found = faults(scenario.with_changes({"simulation.physics_step": STEPS[-1]}))
    return "; ".join(str(fault.error) for fault in found)


def _try(scenario: Scenario, end: float) -> tuple[float, bool]:
    """Return the largest error (m) in a run longer than the written one, and whether its loop is stable.

    Raises:
        Interrupted: if the CPU time `end` (s) is reached before.
    """

    def stop(_done: int, _total: int) -> None:
        if process_time() > end:
            raise Interrupted("out of time")

    longer = {"simulation.duration": LONGER * scenario.simulation.duration}
    try:
        run = simulate(scenario, overrides=longer, progress=stop)
    except Interrupted:
        raise
    except SimulationStopped:
        return np.inf, False
    return float(run.summary()["position_error_m"]["max"]), _settles(run, scenario)


def _settles(run: Run, scenario: Scenario) -> bool:
    """Return whether errors stay small and do not grow, and tensions are neither zero nor too large.

    With a pretension, no tension may be too small, too: a higher pretension may prevent it.
    """
    figures, robot = run.summary(), scenario.robot
    beyond = figures["beyond_limits_steps"]
    if figures["slack_samples"] or beyond["tension_above_max"]:
        return False
    if beyond["tension_below_min"] and getattr(scenario.controller_options, "pretension", 0.0):
        return False
    extent = _extent(robot)
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


def _extent(robot: Robot) -> float:
    """Return the diagonal of the frame, m."""
    return float(np.linalg.norm(np.ptp(robot.anchors[:, :3], axis=0)))


def _remedy(scenario: Scenario) -> str:
    if all(not cable.damping for cable in scenario.robot.cables):
        return "they have no damping; give robot.cable.damping (N s/m), or friction to robot.winch"
    return "give more robot.cable.damping (N s/m), stiffer cables, or friction to robot.winch"
