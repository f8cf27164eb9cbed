"""Warnings about unstable and under-sampled loops of a scenario, with remedies that were tried."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from cdpr.base.errors import CdprError
from cdpr.base.problems import Path
from cdpr.cables import rubs, takes_lengths
from cdpr.mechanics.kinematics import lengths
from cdpr.mechanics.stability import exit_slopes
from cdpr.model.robot import Array
from cdpr.scenario import Scenario
from cdpr.simulation.build import check_cables
from cdpr.simulation.columns import chosen_plugins
from cdpr.simulation.estimation import estimator_of
from cdpr.simulation.linear_map import Linearised
from cdpr.simulation.linearised import Linearisation, linearise
from cdpr.simulation.poles import (
    PHYSICS_STEP,
    STABLE,
    UNDAMPED,
    UNDECIDED,
    UNSTABLE,
    bandwidths,
    pole_text,
    poles,
    sampling,
    verdict,
)
from cdpr.simulation.step_checks import StepTooLongError

NOT_COMPUTED = "not computed: "  # begin of a reason why there is no verdict
STEP, INITIAL = "simulation.physics_step ", "at the initial pose"  # in errors of the build
SAMPLES = 65  # poses along the motion
HALVINGS = 6  # of a bandwidth, in trials of remedies
GROWN = math.log(10.0)

# Powers of the bandwidth to which gains of the controllers are proportional.
POWERS = {"kp": 2, "kd": 1, "ki": 3}
WORSE = STABLE, UNDAMPED, UNDECIDED, UNSTABLE  # verdicts, the worst last
SERVO_GAINS = "position_gain", "velocity_gain"

SLOW = 0.2  # of the designed bandwidth, below which errors of the motion are several times those of the controller
SLOW_REMEDIES = (
    "give the winches higher gains (robot.winch.position_gain) or stiffer cables, or command lengths, such as with the "
    "controller inverse_kinematics and flex_compensation"
)


def loop_problems(scenario: Scenario) -> tuple[str, list[tuple[Path, str]]]:
    """Return the verdict on the loop at the start and at the end of the motion, and warnings with their keys.

    The verdict is the worse of both of `cdpr.simulation.poles.verdict`, or the reason why there is none.
    """
    found = dict(_steps_along_motion(scenario))
    known = STABLE
    if estimator_of(scenario) is not None:  # the loop has no linearisation, but drives are slow with any estimator
        found.update(_slow_with_true_state(scenario))
    with Linearisation(scenario) as linearisation:
        for where, pose in rest_poses(scenario).items():
            try:
                loop = linearisation.at(pose, response=takes_lengths(scenario.robot))
            except CdprError as error:
                reason = str(error).replace(INITIAL, f"at the {where}")  # at which the loop was built
                if isinstance(error, StepTooLongError):  # only at this pose, or the scenario is rejected
                    found[PHYSICS_STEP] = reason.removeprefix(STEP)
                return f"{NOT_COMPUTED}{reason}", list(found.items())
            here = verdict(loop)
            known = max(known, here, key=WORSE.index)
            for path, text in _problems(scenario, pose, where, loop, here):
                found.setdefault(path, text)
            if here == UNSTABLE:
                break
    return known, list(found.items())


def _problems(scenario: Scenario, pose: Array, where: str, loop: Linearised, here: str) -> Iterator[tuple[Path, str]]:
    """Yield the problems of a loop with a verdict at a pose, with their keys."""
    doubtful = here in (UNSTABLE, UNDECIDED)
    modes = poles(loop) if doubtful or not loop.seen_every else []  # slow with measurements, which need no more
    worst = modes[0] if modes else None
    if worst is not None and worst.value.real > 0.0 and doubtful:
        be = "is" if here == UNSTABLE else "may be"
        mode = f"{_growth(worst.value)} and moves {', '.join(worst.moves)}"
        yield (
            ("controller",),
            (f"the closed loop {be} unstable at rest at the {where}: {mode}; {_remedies(scenario, pose)}"),
        )
    yield from sampling(loop, scenario, modes)
    if here == STABLE and (text := _slowness(scenario, loop)):
        yield ("controller",), f"{text} at the {where}: {SLOW_REMEDIES}"


def _slow_with_true_state(scenario: Scenario) -> Iterator[tuple[Path, str]]:
    """Yield the warning of slow drives for the loop without estimator and sensors."""
    if not takes_lengths(scenario.robot):
        return
    try:
        direct = scenario.replace(estimator=None, sensors=None, events=None)
        with Linearisation(direct) as linearisation:
            for where, pose in rest_poses(scenario).items():
                loop = linearisation.at(pose, response=True)
                if verdict(loop) == STABLE and (text := _slowness(direct, loop)):
                    yield (
                        ("controller",),
                        f"{text} at the {where}, with the true state instead of the estimate: {SLOW_REMEDIES}",
                    )
                    return
    except CdprError:
        return  # `loop_problems` states why the loop has no linearisation


def _slowness(scenario: Scenario, loop: Linearised) -> str:
    """Return the warning that drives which hold lengths follow the controller slowly; "" if they do not."""
    kp, kd = (np.array(getattr(scenario.controller_options, key, 0.0), dtype=float) for key in ("kp", "kd"))
    if not takes_lengths(scenario.robot) or not kp.all() or not kd.all():
        return ""
    designed = float(np.abs(np.array([np.roots([1.0, d, p]) for p, d in np.broadcast(kp, kd)])).min()) / (2.0 * math.pi)
    slowest = min((band for band in bandwidths(loop) if band is not None), default=math.inf)
    if slowest >= SLOW * designed:
        return ""
    bands = f"its bandwidth is {slowest:.2g} Hz, that of kp and kd {designed:.2g} Hz"
    return f"the drives make the closed loop slow: {bands}"


def _steps_along_motion(scenario: Scenario) -> Iterator[tuple[Path, str]]:
    """Yield a warning if the physics step is too long at a later pose of the motion.

    Two poses are checked: those with the shortest cable, which is the stiffest, and with the most friction on pulleys.
    """
    if scenario.immediate_cables or scenario.actuators is not None:
        return
    robot = scenario.robot
    times = np.linspace(0.0, scenario.simulation.duration, SAMPLES).tolist()
    states = [scenario.desired.sample(time)[:13] for time in times]
    least = [int(np.argmin([lengths(robot, state).min() for state in states]))]
    if rubs(robot):
        least.append(int(np.argmax([exit_slopes(robot, state).max() for state in states])))
    for k in sorted(set(least)):
        try:
            check_cables(scenario, chosen_plugins(scenario)["backend"], states[k])
        except StepTooLongError as error:
            text = str(error).replace(INITIAL, f"at {times[k]:.4g} s of the motion").replace("would", "may")
            yield PHYSICS_STEP, text.removeprefix(STEP)
            return


def rest_poses(scenario: Scenario) -> dict[str, Array]:
    """Return the poses (7,) at which the motion starts and ends, without a repetition."""
    start, desired = scenario.initial.state()[:7], np.zeros(19)
    scenario.desired.sampler(desired)(scenario.simulation.duration)
    still = np.abs(desired[7:13]).max() < 1e-9
    if not still or np.allclose(start, desired[:7], 0.0, 1e-9):
        return {"initial pose": start}
    return {"initial pose": start, "end of the motion": desired[:7]}


def _growth(pole: complex) -> str:
    tenfold = f"({pole_text(pole)}) grows tenfold in {GROWN / pole.real:.2g} s"
    return f"a vibration of {pole.imag / (2.0 * math.pi):.3g} Hz {tenfold}" if pole.imag else f"a motion {tenfold}"


def _remedies(scenario: Scenario, pose: Array) -> str:
    """Return changes with which the loop is stable at the pose, each the smallest of its kind."""
    kinds = _gains(scenario), _steps(scenario), _damping(scenario), _servos(scenario)
    working = [text for kind in kinds if (text := _first(scenario, pose, kind))]
    if not working:
        more = "" if scenario.ideal_cables else ": give more robot.cable.damping, or friction to robot.winch"
        return f"no stable gains were found{more}"
    return f"it is stable with {', or with '.join(working)}"


def _first(scenario: Scenario, pose: Array, kind: Iterator[Mapping[str, Any]]) -> str:
    for changes in kind:
        try:
            stable = verdict(linearise(scenario.with_changes(changes), pose)) == "stable"
        except CdprError:
            continue
        if stable:
            return " and ".join(f"{key} {_number(value)}" for key, value in changes.items())
    return ""


def _gains(scenario: Scenario) -> Iterator[Mapping[str, Any]]:
    """Yield lower gains of the controller, each time half the bandwidth."""
    options = scenario.controller_options
    own = {key: getattr(options, key) for key in POWERS if np.any(getattr(options, key, 0.0))}
    for halving in range(1, (HALVINGS if own else 0) + 1):
        share = {key: 0.5 ** (halving * POWERS[key]) for key in own}
        yield {f"controller.{key}": _scaled(value, share[key]) for key, value in own.items()}


def _scaled(value: Any, factor: float) -> Any:
    return [factor * each for each in value] if isinstance(value, list | tuple) else factor * value


def _steps(scenario: Scenario) -> Iterator[Mapping[str, Any]]:
    """Yield shorter control steps."""
    simulation = scenario.simulation
    for factor in (2, 4, 8):
        step = simulation.control_step / factor
        shorter = {} if simulation.physics_step <= step else {"simulation.physics_step": step}
        yield {"simulation.control_step": step, **shorter}


def _damping(scenario: Scenario) -> Iterator[Mapping[str, Any]]:
    """Yield more damping of the cables."""
    if scenario.ideal_cables:
        return
    least = max(max(cable.damping for cable in scenario.robot.cables), 1.0)
    for factor in (2.0, 5.0, 10.0, 50.0):
        yield {"robot.cable.damping": float(f"{factor * least:.2g}")}


def _servos(scenario: Scenario) -> Iterator[Mapping[str, Any]]:
    """Yield lower gains of the servos."""
    winch = scenario.robot.cables[0].winch
    for key in SERVO_GAINS:
        value = 0.0 if winch is None else float(winch.own.get(key, 0.0))
        for halving in range(1, 5 if value else 1):
            yield {f"robot.winch.{key}": value * 0.5**halving}


def _number(value: Any) -> str:
    return f"[{', '.join(f'{each:.4g}' for each in value)}]" if isinstance(value, list) else f"{value:.4g}"
