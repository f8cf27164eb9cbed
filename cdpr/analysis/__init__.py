"""Analyses of robots, solvers and runs. They compute; `cdpr.ui` draws.

Example:
    >>> import cdpr
    >>> robot = cdpr.load_robot("caroca")
    >>> cdpr.analysis.distribution.distribute(robot, robot.home).status
    <Status.OK: 0>
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cdpr.analysis import bench, compare, design, distribution, jobs, rollouts, sizing, study, workspace
else:
    from cdpr.base.lazy import lazily

    __getattr__ = lazily(__name__)

__all__ = ["bench", "compare", "design", "distribution", "jobs", "rollouts", "sizing", "study", "workspace"]
