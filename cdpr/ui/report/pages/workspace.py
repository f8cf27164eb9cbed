"""Page of a workspace: its 3D view with the robot, slices through it, and its figures."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np

from cdpr.analysis.workspace import Workspace
from cdpr.analysis.workspace.surface import surface
from cdpr.mechanics.properties import home_pose
from cdpr.model import Robot
from cdpr.model.robot import DOF_NAMES
from cdpr.scene import Subject
from cdpr.ui.report.figures import slices
from cdpr.ui.report.pages.page import figure, page, section, theatre
from cdpr.ui.report.pages.still import still_scene
from cdpr.ui.report.player.arrays import Arrays
from cdpr.ui.report.player.assets import viewer
from cdpr.ui.report.player.data import page_data
from cdpr.ui.report.player.scenes import scene
from cdpr.ui.report.plots.survey import pose_pictures
from cdpr.ui.report.text.workspace import lines

Slice = tuple[int, float]  # axis, and position of the plane, m


def render_workspace(found: Workspace, robot: Robot, chosen: Sequence[Slice] = ()) -> str:
    """Return the page as HTML, with these slices, or by default with slices through the middle of the workspace."""
    title, arrays = f"{found.robot}: {found.kind.name} workspace", Arrays()
    shown = pose_pictures(home_pose(robot)[0], Subject.of_robot(robot))
    flat = len(found.region.moving) < 3
    space = scene(shown, arrays)
    closed = None if flat else surface(found)
    if closed is not None:
        corners, triangles = closed
        space["region"] = {"vertices": arrays.fine(corners), "triangles": arrays.fine(triangles)}
    data = page_data(None, [space], {}, arrays, (0.0, 0.0), [])
    about = "The surface between cells that are inside and those that are not, and the robot in its home pose."
    if flat:
        about = "The robot in its home pose; the workspace lies in a plane."
    gallery = []
    for k, (axis, place) in enumerate(chosen or _middle(found)):
        name = DOF_NAMES[axis]
        at = found.region.axes[axis][int(np.argmin(np.abs(found.region.axes[axis] - place)))]
        heading = f"At {name} = {at:.4g} m"
        svg = slices.draw(found, robot, axis, place).markup(f"{title}, {heading}")
        caption = f"Cells that are inside, by their {escape(found.kind.value)}; the frame and the anchors on it."
        if found.proofs is not None:
            caption = caption.replace("are inside,", "are proved to be inside,") + " Grey: undecided."
        gallery.append(figure(f"slice-{k}", heading, svg, caption))
    parts = [theatre(figure("space", "In space", still_scene(shown, title, closed), about, live=viewer(data)), gallery)]
    parts.append(section("figures", f"<h2>Figures</h2>\n<pre>{escape(chr(10).join(lines(found.summary())))}</pre>"))
    links = {"space": "In space", **{f"slice-{k}": f"Slice {k + 1}" for k in range(len(gallery))}, "figures": "Figures"}
    return page(title, found.kind.title, "", links, parts, data)


def _middle(found: Workspace) -> list[Slice]:
    """Return one slice per axis through the middle of the workspace; of a planar workspace its plane."""
    region = found.region
    if len(region.moving) < 3:
        axis = next(i for i in range(3) if i not in region.moving)
        return [(axis, float(region.lower[axis]))]
    here = np.argwhere(found.inside)
    middle = here.mean(axis=0) if len(here) else 0.5 * np.array(region.shape)
    return [(axis, float(region.axes[axis][int(middle[axis])])) for axis in (2, 1, 0)]
