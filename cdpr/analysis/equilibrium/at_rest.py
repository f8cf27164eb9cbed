"""Poses at rest for given unwound lengths, drum angles or tensions."""

from __future__ import annotations

import warnings
from numbers import Integral

import numpy as np
from numpy.typing import ArrayLike

from cdpr.base import tolerances
from cdpr.base.defaults import MOST_STARTS
from cdpr.base.errors import CdprError
from cdpr.base.fields import MAX_UNWOUND
from cdpr.base.problems import shown
from cdpr.cables.drum import RADIUS
from cdpr.cables.drums import unwound_lengths
from cdpr.mechanics.equilibria import find_equilibria
from cdpr.mechanics.equilibrium import Equilibrium, find_equilibrium
from cdpr.mechanics.kinematics import lengths as lengths_at
from cdpr.mechanics.kinematics import make_state
from cdpr.model import Cable, Robot
from cdpr.model.arrays import checked
from cdpr.model.robot import Array
from cdpr.model.rotations import held_upright
from cdpr.scenario.evaluated_pose import evaluated_pose
from cdpr.scenario.loader import AnyRobot, robot_or_scenario
from cdpr.scenario.option_migration import outside
from cdpr.scenario.sound_robot import sound

STARTS = 100  # random starts of a search for all equilibria
LONG = 100.0  # unwound lengths by the size of the robot; lengths in mm are a thousand times too long


def equilibrium(
    robot: AnyRobot,
    *,
    lengths: ArrayLike | None = None,
    tensions: ArrayLike | None = None,
    drum_angles: ArrayLike | None = None,
    start: ArrayLike | None = None,
    gravity: ArrayLike | None = None,
) -> Equilibrium:
    """Compute the pose at which the platform comes to rest.

    It is the minimum of the potential energy that is reached downhill from the start. The robot may have any number of
    cables and degrees of freedom. Cables become slack where this is so. Cables of the models `ideal` and `rigid` do not
    stretch: their lengths are upper limits, and lengths that contradict each other are reported.

    Each cable needs one value in one of `lengths`, `tensions` and `drum_angles`; give NaN for it in the others.

    Args:
        robot: a Robot, a file, the name of an example, a dict or a Scenario.
        lengths: (m,) unwound lengths of the unloaded cables, with the cable on pulleys [m].
        tensions: (m,) constant tensions [N].
        drum_angles: (m,) drum angles [rad], positive when winding in. At 0, the unwound length is the length of the
            cable's path at the home pose, so the winch needs a drum radius.
        start: (7,) initial pose: position [m] and quaternion w, x, y, z. Default: the home pose, or the initial pose of
            a scenario. Directions in which the robot does not move keep their values.
        gravity: (3,) gravity [m/s^2], world axes. Default: that of the scenario, or of the earth.

    Returns:
        The pose with tensions, stability, frequencies and sensitivities; see `Equilibrium`.

    Raises:
        CdprError: if an argument is wrong. Impossible lengths raise no error: see `Equilibrium.converged`.

    Warns:
        UserWarning: if a length is many times the size of the robot, as if it were in millimetres.

    Example:
        >>> import cdpr
        >>> frame, platform = [[-1.0, 0.0, 2.0], [1.0, 0.0, 2.0]], [[0.0, 0.0, 0.0]] * 2
        >>> robot = cdpr.Robot.from_points(frame, platform, mass=2.0, dof=["x", "z"])
        >>> found = cdpr.equilibrium(robot, lengths=[1.25, 1.25])
        >>> found.pose[2].round(9), found.stability
        (np.float64(1.25), 'stable')
    """
    return find_equilibrium(*_arguments(robot, lengths, tensions, drum_angles, start, gravity))


def equilibria(
    robot: AnyRobot,
    *,
    lengths: ArrayLike | None = None,
    tensions: ArrayLike | None = None,
    drum_angles: ArrayLike | None = None,
    start: ArrayLike | None = None,
    gravity: ArrayLike | None = None,
    starts: int = STARTS,
    seed: int = 0,
) -> list[Equilibrium]:
    """Compute all poses at rest that a search from many random poses finds, unstable ones included.

    Args:
        robot: as for `equilibrium`.
        lengths: as for `equilibrium`.
        tensions: as for `equilibrium`.
        drum_angles: as for `equilibrium`.
        start: as for `equilibrium`.
        gravity: as for `equilibrium`.
        starts: number of random initial poses, at most 10 000. More starts may find more equilibria.
        seed: seed of the random poses.

    Returns:
        The converged equilibria: stable before unstable ones, then by height.

    Raises:
        CdprError: if an argument is wrong.

    Example:
        >>> import cdpr
        >>> frame, platform = [[0.0, 0.0, 2.0]], [[0.0, 0.0, 0.0]]
        >>> pendulum = cdpr.Robot.from_points(frame, platform, mass=1.0, dof=["x", "z"])
        >>> [(float(one.pose[2].round(9)), one.stability) for one in cdpr.equilibria(pendulum, lengths=[1.5], starts=5)]
        [(0.5, 'stable')]
    """
    if isinstance(starts, bool) or not isinstance(starts, Integral) or not 0 <= starts <= MOST_STARTS:
        raise CdprError(f"equilibria(starts=): expected a whole number from 0 to {MOST_STARTS}, got {shown(starts)}")
    if isinstance(seed, bool) or not isinstance(seed, Integral) or seed < 0:
        raise CdprError(f"equilibria(seed=): expected a whole number of at least 0, got {shown(seed)}")
    found = _arguments(robot, lengths, tensions, drum_angles, start, gravity)
    return find_equilibria(*found, starts=int(starts), seed=int(seed))


def _arguments(
    source: AnyRobot,
    lengths: ArrayLike | None,
    tensions: ArrayLike | None,
    drum_angles: ArrayLike | None,
    start: ArrayLike | None,
    gravity: ArrayLike | None,
) -> tuple[Robot, Array, Array, Array, Array]:
    """Return robot, unwound lengths, tensions, start and gravity, checked."""
    loaded = sound(source) if type(source) is Robot else robot_or_scenario(source)
    given = None if start is None else _pose(start)
    robot, own, pose, _ = evaluated_pose(loaded, given)
    if not held_upright(robot.dof, pose[3:]):
        raise CdprError(f"start: expected rotations about the axes of {', '.join(robot.dof)} only")
    unwound = _values(robot, lengths, "lengths")
    tension = _values(robot, tensions, "tensions")
    angle = _values(robot, drum_angles, "drum_angles")
    turned = ~np.isnan(angle)
    for i, cable in enumerate(robot.cables):
        count = sum(not np.isnan(values[i]) for values in (unwound, tension, angle))
        if count != 1:
            text = "expected one value in lengths, tensions or drum_angles"
            raise CdprError(f"equilibrium: cable '{cable.name}': {text}, got {count or 'none'}")
    if turned.any():
        wound = unwound_lengths(robot, angle[None])[0]
        for k in np.flatnonzero(turned):
            _require_drum(robot.cables[k])
            if np.isnan(wound[k]):
                text = f"at {angle[k]:g} rad the drum is empty: it grows by winch.drum_growth"
                raise CdprError(f"drum_angles: cable '{robot.cables[k].name}': {text}")
        unwound = np.where(turned, wound, unwound)
    for i, (cable, length, force) in enumerate(zip(robot.cables, unwound.tolist(), tension.tolist(), strict=True)):
        if length <= 0.0 or length > MAX_UNWOUND:
            key, where = ("drum_angles", f" at {angle[i]:g} rad") if turned[i] else ("lengths", "")
            text = f"expected an unwound length of more than 0 and at most {MAX_UNWOUND:g} m, got {length:g}{where}"
            raise CdprError(f"{key}: cable '{cable.name}': {text}")
        if force < 0.0 and robot.unilateral:
            raise CdprError(f"tensions: cable '{cable.name}': expected at least 0 N, got {force:g}")
    _warn_of_long_ones(robot, pose, np.where(turned, np.nan, unwound))
    down = checked(own if gravity is None else gravity, (3,), "gravity", finite=True)
    return robot, unwound, tension, pose.copy(), down


def _warn_of_long_ones(robot: Robot, pose: Array, unwound: Array) -> None:
    """Warn of given lengths (m,) that are many times the size of the robot, such as those in millimetres."""
    paths = lengths_at(robot, make_state(pose[:3], pose[3:]))
    size = float(np.fmax(np.linalg.norm(np.ptp(robot.anchors[:, :3], axis=0)), np.nanmax(paths, initial=0.0)))
    long = np.flatnonzero(unwound > LONG * size)
    if size > 0.0 and len(long):  # anchors and platform may lie in one point
        i = int(long[0])
        warnings.warn(
            f"lengths: cable '{robot.cables[i].name}': {unwound[i]:g} m is {unwound[i] / size:.3g} times the size of "
            f"the robot, {size:.4g} m: lengths are in m",
            stacklevel=outside(),
        )


def _require_drum(cable: Cable) -> None:
    try:
        RADIUS.of(cable)
    except CdprError:
        text = f"drum_angles: cable '{cable.name}': expected a winch with a drum radius ({RADIUS.name}), got none"
        raise CdprError(text) from None


def _pose(values: ArrayLike) -> Array:
    pose = checked(values, (7,), "start", finite=True).copy()
    norm = float(np.linalg.norm(pose[3:]))
    if abs(norm - 1.0) > tolerances.UNIT:
        raise CdprError(f"start: expected a quaternion of length 1, got length {norm:.6g}")
    pose[3:] /= norm
    return pose


def _values(robot: Robot, values: ArrayLike | None, name: str) -> Array:
    """Return the values (m,) of cables, NaN for those without."""
    if values is None:
        return np.full(robot.m, np.nan)
    found = checked(values, (robot.m,), name)
    if np.isinf(found).any():
        raise CdprError(f"{name}: expected finite numbers, or NaN for cables without a value")
    return found
