"""Page that shows a run, robot or motion in space: the verb of the Python interface, and its parts for commands."""

from __future__ import annotations

import os
import webbrowser
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from numpy.typing import ArrayLike

from cdpr.analysis.compare.finished import compare_finished
from cdpr.analysis.distribution.motion import describe_loaded
from cdpr.analysis.distribution.survey import Survey
from cdpr.analysis.workspace.path import along
from cdpr.base.errors import CdprError, OutputError
from cdpr.base.user_folders import user_cache
from cdpr.log.files import make_folder, output_path, replace_markup
from cdpr.log.reader import load_run
from cdpr.log.run import Run
from cdpr.model import Robot
from cdpr.model.arrays import checked
from cdpr.model.robot import Array
from cdpr.scenario import Scenario
from cdpr.scenario.evaluated_pose import evaluated_pose
from cdpr.scenario.examples import is_run
from cdpr.scenario.loader import AnyRobot, robot_or_scenario
from cdpr.scene import Pictures, Subject
from cdpr.ui.report.pages.compare import render as render_comparison
from cdpr.ui.report.pages.page import is_page
from cdpr.ui.report.pages.run import render
from cdpr.ui.report.pages.view import render_view
from cdpr.ui.report.plots.survey import pose_pictures, survey_pictures

PAGE = "view.html"


def view(
    what: AnyRobot | Run | Sequence[str],
    out: str | os.PathLike[str] | None = None,
    *,
    pose: ArrayLike | None = None,
    show: bool | None = None,
) -> Path:
    """Write a page that shows a run, a robot or a scenario's motion in space, and open it in a browser.

    Args:
        what: a Run, a Robot, a Scenario, their file or folder, the name of an example, or a dict; or a list of folders
            of runs, which are superimposed.
        out: the page, a name that ends in .html; by default one in the user's cache.
        pose: (7,), position (m) and quaternion of a robot; its home by default.
        show: open the page; by default if `out` is not given.

    Returns:
        The page.

    Raises:
        CdprError: if an argument is wrong.
        OutputError: if the page cannot be written, or is another file.

    Example:
        >>> import tempfile
        >>> import cdpr
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     print(cdpr.view("caroca", f"{folder}/caroca.html").name)
        caroca.html
    """
    target = user_cache() / PAGE if out is None else output_path(out, "view(out=)")
    if target.suffix != ".html" or (target.exists() and not (target.is_file() and is_page(target.read_bytes()))):
        raise OutputError(f"view(out=): '{target}': expected the name of a new page that ends in .html")
    page = _page(what, pose)
    make_folder(target.parent)
    replace_markup(target, page)
    if out is None if show is None else show:
        webbrowser.open(target.resolve().as_uri())
    return target


def _page(what: Any, pose: ArrayLike | None) -> str:
    several = isinstance(what, list | tuple)
    run = what if isinstance(what, Run) else load_run(os.fspath(what)) if is_run(what) else None
    if pose is not None and (run is not None or several):
        raise CdprError("view(pose=): applies to robots and scenarios, not to runs")
    if several or run is not None:
        return page_of_runs(what if run is None else run)
    loaded = robot_or_scenario(what)
    at = None if pose is None else checked(pose, (7,), "view(pose=)", finite=True)
    return page_of(loaded, *evaluated_pose(loaded, at)[1:])


def page_of_runs(runs: Run | Sequence[str]) -> str:
    """Return the page of a run, or of two or more folders or logs of runs, which are superimposed."""
    return render(runs) if isinstance(runs, Run) else render_comparison(compare_finished(runs))


def page_of(loaded: Scenario | Robot, gravity: Array, at: Array, source: str) -> str:
    """Return the page of a robot or of a scenario's motion; arguments as for `analysed`."""
    return render_view(loaded.name, *analysed(loaded, gravity, at, source))


def analysed(
    loaded: Scenario | Robot, gravity: Array, at: Array, source: str
) -> tuple[dict[str, Any], Pictures, Survey | None]:
    """Return figures as plain data, pictures, and for a scenario its motion, without simulation.

    `gravity` is (3,), m/s^2, world; the robot is shown in the pose `at` (7,), which comes from `source`.
    """
    figures, motion = describe_loaded(loaded, gravity, at, source)
    subject = Subject.of_robot(loaded.robot if isinstance(loaded, Scenario) else loaded)
    if motion is None or not isinstance(loaded, Scenario):
        return figures, pose_pictures(at, subject), motion
    poses = motion.desired[:, :7]
    figures["motion"]["least"] = along(loaded.controlled_robot, motion.time, poses, gravity, loaded.obstacles)
    return figures, survey_pictures(motion, subject), motion
