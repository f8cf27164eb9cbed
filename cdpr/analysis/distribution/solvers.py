"""Comparison of installed solvers at one pose, from any description of a robot: the figures of `cdpr tension`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from numpy.typing import ArrayLike

from cdpr.analysis.distribution.comparison import Contestant, compare, describe
from cdpr.analysis.distribution.distributions import check_unit
from cdpr.analysis.distribution.source import options_of
from cdpr.base.defaults import SOLVER
from cdpr.base.errors import CdprError
from cdpr.base.problems import shown
from cdpr.base.redirect_output import redirect_output
from cdpr.log.run_json import to_json
from cdpr.mechanics.dynamics import required_wrench
from cdpr.mechanics.kinematics import make_state
from cdpr.mechanics.properties import check_lengths
from cdpr.model import Robot
from cdpr.model.arrays import checked
from cdpr.plugins.registry import Registered, registry
from cdpr.scenario import Scenario
from cdpr.scenario.evaluated_pose import evaluated_pose
from cdpr.scenario.loader import AnyRobot, robot_or_scenario
from cdpr.tension.problem import Problem
from cdpr.tension.stage import Solve

ALL = "all"  # in place of the names of all solvers


def compare_solvers(
    robot: AnyRobot,
    pose: ArrayLike | None = None,
    wrench: ArrayLike | None = None,
    *,
    solvers: Sequence[str] = (SOLVER,),
    progress: Callable[[int, int], None] | None = None,
) -> dict[str, Any]:
    """Distribute one wrench at one pose with several solvers, and check each answer.

    The answers are those of the solvers, even if they violate limits; `cdpr.distribute` returns tensions within them.

    Args:
        robot: a Robot, a file, the name of an example, a dict or a Scenario, whose controlled directions, gravity and
            solver options apply.
        pose: (7,), position (m) and quaternion w, x, y, z; by default the scenario's initial pose or the robot's home.
        wrench: (6,), wrench of the cables on the platform at its origin (N, N m, world axes); by default that which
            balances the weight.
        solvers: names; "all" for all, including those that lack a package.
        progress: called with the number of finished solvers and the total.

    Returns:
        Problem and answers as plain data with units in the names: the output of `cdpr tension --json`.

    Raises:
        CdprError: if an argument is wrong, or a cable has zero length.
        PluginError: if a named solver is unknown or lacks a package.

    Example:
        >>> from cdpr.analysis.distribution.solvers import compare_solvers
        >>> figures = compare_solvers("caroca", solvers=["qp", "lp"])
        >>> [(answer["solver"], answer["admissible"]) for answer in figures["solvers"]]
        [('qp', True), ('lp', True)]
    """
    if isinstance(solvers, str) or not all(isinstance(name, str) for name in solvers):
        raise CdprError(f"compare_solvers(solvers=): expected a list of names, got {shown(solvers)}")
    loaded = robot_or_scenario(robot)
    given = None if pose is None else checked(pose, (7,), "pose", finite=True)
    if given is not None:
        check_unit(given[None], "pose")
    whole, gravity, at, source = evaluated_pose(loaded, given)
    check_lengths(whole, at)
    if wrench is None:
        load, whence = required_wrench(whole, make_state(at[:3], at[3:]), gravity), "holds the weight"
    else:
        load, whence = checked(wrench, (6,), "wrench", finite=True), "wrench"
    problem = Problem(loaded.controlled_robot if isinstance(loaded, Scenario) else loaded, at, load)
    with redirect_output():
        answers = compare(problem, _contestants(solvers, problem.robot, loaded), progress)
    figures: dict[str, Any] = to_json(describe(problem, answers, source, whence))
    return figures


def _contestants(names: Sequence[str], robot: Robot, loaded: Robot | Scenario) -> list[Contestant]:
    """Return the solvers with these names.

    Raises:
        PluginError: if a named solver is unknown or lacks a package.
    """
    found = registry()
    chosen: dict[str, Registered] = {}
    for name in names:
        for each in found.names("solver") if name == ALL else [name]:
            chosen[each] = found.get("solver", each)
            if name != ALL:
                chosen[each].load()

    def contestant(name: str, entry: Registered) -> Contestant:
        def make() -> Solve:
            solve: Solve = entry.make(robot, options_of(loaded, name) or entry.read_options({})).solve
            return solve

        absent = f"not installed: {entry.remedy}" if entry.missing else ""
        return Contestant(name, make, bool(entry.info.properties.get("respects_bounds", True)), absent)

    return [contestant(name, entry) for name, entry in chosen.items()]
