"""Checks of a controller."""

from __future__ import annotations

from dataclasses import replace
from time import perf_counter

import numpy as np

from cdpr.base.errors import CdprError, PluginError
from cdpr.base.problems import short_repr
from cdpr.mechanics import dynamics, kinematics
from cdpr.model import Robot, rotations
from cdpr.model.robot import Array, frozen_array
from cdpr.plugins import Controller
from cdpr.plugins.controller import OUTPUTS
from cdpr.testing import samples
from cdpr.testing.changes import expect_changes
from cdpr.testing.check import Check, expect, expect_close, expect_same_bits, needs
from cdpr.testing.columns import expect_written
from cdpr.testing.samples import GRAVITY, NO_GRAVITY
from cdpr.testing.sensors import MOUNTED
from cdpr.testing.subjects import ControllerSubject


def _target(state: Array) -> Array:
    """Return a state (13,) as a constant desired state (19,)."""
    return np.concatenate([state, np.zeros(6)])


def _rest(seed: int) -> Array:
    return samples.state(np.random.default_rng(seed), speed=0.0, tilt=0.3)


def _motion(k: int) -> tuple[Array, Array]:
    """Return a state and a desired state near it; all k are close to each other, as in a motion."""
    rng = np.random.default_rng(k)
    q = rotations.from_rpy(*(np.array([0.1, -0.05, 0.2]) + 0.02 * rng.normal(size=3)))
    position = np.array([0.1, -0.1, 2.0]) + 0.02 * rng.normal(size=3)
    desired = np.concatenate([position, q, 0.1 * rng.normal(size=12)])
    state = desired[:13] + 0.01 * rng.normal(size=13)
    state[3:7] /= np.linalg.norm(state[3:7])
    return state, desired


def output_is_complete(subject: ControllerSubject) -> str:
    """The controller writes a finite number into every entry of its output.

    The states in this check are near the desired states.
    """
    controller = subject.make(samples.braced())
    started = perf_counter()
    for k in range(200):
        out = subject.compute(controller, *_motion(k), time=1e-3 * k)
        expect(np.isfinite(out).all(), f"output {out.tolist()}")
    return f"{1e6 * (perf_counter() - started) / 200:.0f} us a call, samples included"


def inputs_stay_unchanged(subject: ControllerSubject) -> None:
    """The controller does not change its inputs: the state and the desired state."""
    controller = subject.make(samples.braced())
    for k in range(20):
        state, desired = _motion(k)
        copies = state.copy(), desired.copy()
        subject.compute(controller, *copies)
        expect_same_bits(copies[0], state, "state after control")
        expect_same_bits(copies[1], desired, "desired state after control")


def reset_forgets(subject: ControllerSubject) -> None:
    """After `reset`, the outputs are identical to those of a new object."""
    used, fresh = subject.make(samples.braced()), subject.make(samples.braced())
    for k in range(50):
        subject.compute(used, *_motion(k), time=1e-3 * k)
    used.reset()
    for k in range(20):
        motion = _motion(100 + k)
        again, wanted = (subject.compute(controller, *motion, time=1e-3 * k) for controller in (used, fresh))
        expect_same_bits(again, wanted, "output after reset")


def period_is_whole(subject: ControllerSubject) -> str:
    """The attribute `period` is a whole number of control steps, at least 1.

    The declared `output` is an allowed word, such as `wrench` or `command`.
    """
    controller = subject.make(samples.braced())
    output = controller.output or subject.properties.get("output", "wrench")
    expect(output in OUTPUTS, f"output {short_repr(output)}: expected one of {', '.join(OUTPUTS)}")
    period = controller.period
    whole = isinstance(period, int | np.integer) and not isinstance(period, bool) and period >= 1
    expect(whole, f"period {short_repr(period)}: expected a whole number from 1 on")
    return f"output {output}, every {period} control steps"


def inputs_may_change(subject: ControllerSubject) -> None:
    """The output stays finite if the tension limits change or a cable breaks during a run.

    Skipped for controllers without the method `observe`.
    """
    controller = subject.make(samples.braced())
    needs(type(controller).observe is not Controller.observe, "it does not observe limits and held cables")
    for k in range(40):
        if k == 10:
            subject.limits[1] *= 0.5
        if k == 20:
            subject.limits[:, 0], subject.held[0] = 0.0, True
        out = subject.compute(controller, *_motion(k), time=1e-3 * k)
        expect(np.isfinite(out).all(), f"output {out.tolist()}")


def tensions_are_corrected(subject: ControllerSubject) -> str:
    """The inner loop writes finite tensions within the limits, and repeats them after `reset` and `restore`.

    Skipped for controllers without the method `inner_loop`.
    """
    robot = samples.braced()
    controller = subject.make(robot)
    needs(type(controller).inner_loop is not Controller.inner_loop, "it has no inner loop")

    def corrected(first: int) -> list[Array]:
        answers = (_corrected(subject, controller, k) for k in range(first, first + 20))
        return [answer for answer in answers if answer is not None]

    begin = corrected(0)
    later, snapshot = corrected(20), controller.snapshot()
    ways = [corrected(40), later]
    controller.restore(snapshot)
    ways[1] = corrected(40)
    controller.reset()
    for answers, wanted, when in ((ways[1], ways[0], "the snapshot"), (corrected(0), begin, "reset")):
        for here, there in zip(answers, wanted, strict=True):
            expect_same_bits(here, there, f"tensions after {when}")
    change = max(float(np.abs(after - _distributed(robot, k)).max()) for k, after in enumerate(begin))
    return f"it changes tensions by up to {change:.3g} N"


def _distributed(robot: Robot, k: int) -> Array:
    """Return tensions (m,) within the limits, N, for a sample."""
    share = np.random.default_rng(k).uniform(0.2, 0.8, robot.m)
    return robot.tension_min + share * (np.minimum(robot.tension_max, robot.tension_min + 1e3) - robot.tension_min)


def _corrected(subject: ControllerSubject, controller: Controller, k: int) -> Array | None:
    """Return the tensions of the inner loop for a sample (m,), N; None without one."""
    robot, wanted = controller.robot, _distributed(controller.robot, k)
    tension = subject.corrected(controller, wanted, wanted - 5.0, 1e-3 * (k + 1))
    if tension is None or subject.missing is not None:
        return tension
    expect(np.isfinite(tension).all(), f"tensions {tension.tolist()}")
    within = (tension >= robot.tension_min).all() and (tension <= robot.tension_max).all()
    expect(within, f"tensions beyond their limits: {tension.tolist()}")
    return tension


def platform_is_renewed(subject: ControllerSubject) -> None:
    """After `renew(robot)` and `reset`, the outputs are identical to those of a new object for this robot.

    Skipped if `renew` returns False.
    """
    robot = samples.laden(samples.braced())
    used, fresh = subject.make(samples.braced()), subject.make(robot)
    for k in range(20):
        subject.compute(used, *_motion(k), time=1e-3 * k)
    needs(used.renew(robot), "it does not support renew")
    used.reset()
    for k in range(20):
        again, wanted = (subject.compute(controller, *_motion(100 + k), time=1e-3 * k) for controller in (used, fresh))
        expect_same_bits(again, wanted, "output with the other platform")


def columns_are_written(subject: ControllerSubject) -> str:
    """In each sample, the controller writes finite numbers into all columns of the log that it declares.

    It writes nothing outside these columns. Skipped if it declares no columns.
    """
    robot = samples.braced()
    controller = subject.make(robot)

    def work(k: int) -> None:
        subject.compute(controller, *_motion(k), time=1e-3 * k)
        _corrected(subject, controller, k)

    return expect_written(subject.columns, robot, controller, controller.reset, work)


def options_change(subject: ControllerSubject) -> str:
    """After `change`, the outputs are identical to those of a new object with the same options.

    If a second `change` sets the first options again, the outputs are the same as without any change. Each changeable
    option must have an effect. Skipped without `changeable` options.
    """

    def compute(controller: Controller, k: int) -> Array:
        out = subject.compute(controller, *_motion(k), time=1e-3 * k)
        tension = _corrected(subject, controller, k)
        return out if tension is None else np.append(out, tension)

    return expect_changes(
        subject.changeable, subject.options, lambda options: subject.having(options).make(samples.braced()), compute
    )


def snapshot_restores(subject: ControllerSubject) -> None:
    """After `restore`, the controller repeats the outputs that followed the snapshot.

    Skipped if `snapshot` raises a `PluginError`.
    """
    controller = subject.make(samples.braced())
    for k in range(30):
        subject.compute(controller, *_motion(k), time=1e-3 * k)
    try:
        snapshot = controller.snapshot()
    except PluginError:
        needs(False, "it does not support snapshots")
    ways = []
    for first in (30, 200, 30):  # in between, continue elsewhere
        ways.append([subject.compute(controller, *_motion(first + k), time=1e-3 * (30 + k)) for k in range(20)])
        controller.restore(snapshot)
    for here, there in zip(ways[0], ways[2], strict=True):
        expect_same_bits(there, here, "output after the snapshot")


def on_target_it_carries_the_weight(subject: ControllerSubject) -> None:
    """If the platform rests at its target, the wrench balances the weight.

    The centre of mass of this platform is not at its origin. Skipped if the output consists of commands.
    """
    needs(not subject.commands, "its output is commands, not a wrench")
    for seed, gravity in ((1, GRAVITY), (2, np.array([1.0, -2.0, -5.0])), (3, NO_GRAVITY)):
        state = _rest(seed)
        wrench = subject.compute(subject.make(samples.braced(), gravity), state, _target(state))
        wanted = dynamics.required_wrench(samples.braced(), state, gravity)
        expect_close(wrench, wanted, 1e-9, "wrench on target, N and N m")


def _needs_pulls(subject: ControllerSubject) -> None:
    _needs_feedback(subject)
    needs(subject.pulls, "its output is lengths or rates of cables, not tensions")


def _needs_feedback(subject: ControllerSubject) -> None:
    needs(subject.properties.get("feedback", True), "it declares feedback: false")


def it_pulls_towards_the_target(subject: ControllerSubject) -> None:
    """If the target moves away from the platform, the wrench towards the target increases.

    The kit shifts the target along each axis: the force along this axis must increase. It also rotates the target about
    each axis: the moment about this axis must increase. Skipped if the controller declares `feedback: false`, or if its
    output is lengths or rates.
    """
    _needs_pulls(subject)
    robot, state = samples.braced(), _rest(4)
    W = kinematics.wrench_matrix(robot, state)
    balance = _wrench(subject, W, subject.compute(subject.make(robot), state, _target(state)))
    for k, direction in enumerate(np.eye(6)):
        target = _target(state)
        target[:3] += 0.01 * direction[:3]
        if k > 2:
            target[3:7] = rotations.multiply(rotations.from_axis_angle(direction[3:], 0.01), state[3:7])
        pull = _wrench(subject, W, subject.compute(subject.make(robot), state, target)) - balance
        expect(pull[k] > 0.0, f"{'force' if k < 3 else 'moment'} {pull[k]:.3g} along {'xyz'[k % 3]}")


def _wrench(subject: ControllerSubject, W: Array, out: Array) -> Array:
    return W @ out if subject.commands else out


def directions_are_equal(subject: ControllerSubject) -> None:
    """The controller works in the same way in all directions.

    The kit applies one rotation to the robot, the motion and gravity. An output wrench must rotate in the same way.
    Output commands must not change. Skipped if the controller declares `isotropic: false`, or if its `sensors` contain
    `markers`: their camera is fixed in the world, so the kit cannot rotate it.
    """
    needs(subject.properties.get("isotropic", True), "it declares isotropic: false")
    needs(not MOUNTED & set(subject.properties.get("sensors", ())), "its sensors are mounted in the world")
    robot = samples.braced()
    q = samples.attitude(np.random.default_rng(5))
    R = rotations.matrix(q)
    here, there = subject.make(robot), subject.make(_turned_robot(robot, R), R @ GRAVITY)
    for k in range(10):
        state, desired = _motion(k)
        out = subject.compute(here, state, desired, 1e-3 * k)
        wanted = out if subject.commands else np.concatenate([R @ out[:3], R @ out[3:]])
        turned = subject.compute(there, _turned(q, state), _turned(q, desired), 1e-3 * k)
        expect_close(turned, wanted, 1e-6 * max(1.0, float(np.abs(out).max())), "output of the turned robot")


def _turned(q: Array, values: Array) -> Array:
    """Return a state or desired state in axes rotated by q."""
    R, values = rotations.matrix(q), values.copy()
    values[3:7] = rotations.multiply(q, values[3:7])
    for start in (0, *range(7, len(values), 3)):
        values[start : start + 3] = R @ values[start : start + 3]
    return values


def _turned_robot(robot: Robot, R: Array) -> Robot:
    return replace(robot, cables=tuple(replace(cable, frame=frozen_array(R @ cable.frame)) for cable in robot.cables))


def nan_shows(subject: ControllerSubject) -> None:
    """If the state contains NaN, the output contains NaN or infinity, or the controller raises an error.

    If the controller declares `sensors`, the same is required for NaN in their measurements. In this part of the check,
    the output includes the tensions of the method `inner_loop`. A controller that declares the sensor `markers` can
    ignore the state, so the kit tests only NaN in its measurements. Skipped if the controller declares
    `feedback: false`.
    """
    _needs_feedback(subject)
    _nan_measurements_show(subject)
    if MOUNTED & set(subject.properties.get("sensors", ())):
        return
    for k in range(13):
        state, desired = _motion(6)
        state[k] = np.nan
        try:
            out = subject.compute(subject.make(samples.braced()), state, desired)
        except CdprError:
            continue
        expect(not np.isfinite(out).all(), f"state[{k}] is NaN, but the output is finite: {out.tolist()}")


def _nan_measurements_show(subject: ControllerSubject) -> None:
    for name, i in subject.measured(subject.make(samples.braced())):
        subject.missing = name, i
        try:
            controller = subject.make(samples.braced())
            out = subject.compute(controller, *_motion(6))
            tension = _corrected(subject, controller, 6)
        except CdprError:
            continue
        shows = not np.isfinite(out if tension is None else np.append(out, tension)).all()
        expect(shows, f"{name}[{i}] is NaN, but the output is finite: {out.tolist()}")
    subject.missing = None


def it_settles(subject: ControllerSubject) -> str:
    """Within three seconds, the controller moves the platform at least halfway to its target.

    At the start, the distance to the target is 3 cm and 0.03 rad. Skipped if the controller declares `feedback: false`,
    or if its output is lengths or rates.
    """
    _needs_pulls(subject)
    robot, step = samples.braced(), 5e-3
    controller = subject.make(robot, step=step)
    target = _target(_rest(7))
    state = target[:13].copy()
    state[:3] += [0.02, -0.02, 0.01]
    state[3:7] = rotations.multiply(rotations.from_axis_angle(np.array([0.0, 0.6, 0.8]), 0.03), state[3:7])
    begin = samples.distance(state, target[:13])
    for k in range(600):
        out = subject.compute(controller, state, target, k * step)
        command, external = np.zeros(robot.m), out
        if subject.commands:
            command, external = np.clip(out, robot.tension_min, robot.tension_max), np.zeros(6)
        state = samples.travel(robot, state, GRAVITY, command, external, step, step)
        expect(np.isfinite(state).all(), f"diverged after {k * step:.3g} s")
    end = samples.distance(state, target[:13])
    expect(end < 0.5 * begin, f"error {end:.3g} m or rad after 3 s, {begin:.3g} at the start")
    return f"error {end:.2g} m or rad after 3 s"


CHECKS = [
    Check(function)
    for function in (
        output_is_complete,
        inputs_stay_unchanged,
        reset_forgets,
        period_is_whole,
        inputs_may_change,
        tensions_are_corrected,
        platform_is_renewed,
        columns_are_written,
        options_change,
        snapshot_restores,
        on_target_it_carries_the_weight,
        it_pulls_towards_the_target,
        directions_are_equal,
        nan_shows,
        it_settles,
    )
]
