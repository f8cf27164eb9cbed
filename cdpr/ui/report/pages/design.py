"""Report of a design: the robot before and after, its figures, convergence and the Pareto front."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from itertools import combinations
from pathlib import Path
from typing import Any

from cdpr.analysis.design import Designed
from cdpr.base.errors import CdprError
from cdpr.log.files import replace_markup
from cdpr.mechanics.properties import home_pose
from cdpr.model import Robot
from cdpr.scene import Pictures, Subject
from cdpr.ui.report.figures.design import convergence, pareto
from cdpr.ui.report.pages.page import banner, figure, hall, page, section, table
from cdpr.ui.report.pages.still import still_scene
from cdpr.ui.report.player.arrays import Arrays
from cdpr.ui.report.player.assets import viewer
from cdpr.ui.report.player.data import page_data
from cdpr.ui.report.player.scenes import scene
from cdpr.ui.report.plots.survey import pose_pictures
from cdpr.ui.report.text.design import chosen, claim, figures, members, remarks, variables

PAIRS = 3  # plotted pairs of goals
FEW_ROWS = 12  # rows of a table that is shown unfolded

CONVERGED = (
    "Dots are candidates that satisfy all constraints, the line is the best so far, the diamond is the initial robot."
)
DOMINATED = (
    "Dots are candidates that keep all constraints; none is better in one goal than those on the line and as good in "
    "the others. The diamond is the robot before, where it keeps them, too; the star is the compromise: nearest to the "
    "best of all goals, each over its extent on the front."
)


def write_design(found: Designed, path: Path) -> None:
    """Write the page.

    Raises:
        OutputError: if the file cannot be written.
    """
    replace_markup(path, render_design(found))


def render_design(found: Designed) -> str:
    """Return the page as HTML."""
    known = found.to_dict()
    best = chosen(known)
    mood, words = claim(known)
    links = {"figures": "Figures"}
    parts = [section("figures", f"<h2>Before and after</h2>\n{_table(figures(known))}{_remarks(known)}")]
    data, space, before = _robots(found, best)
    drawn, titles = _charts(found)
    parts += [hall([*space, *before, *drawn], "wide cards")]
    links |= {"space": "In space"} | titles
    if known["front"]:
        links["front"] = "Front"
        parts.append(section("front", _front(known)))
    links["variables"] = "Variables"
    parts.append(section("variables", f"<h2>Varied keys</h2>\n{_table(variables(known), numeric=False)}"))
    links["about"] = "About"
    parts.append(section("about", _about(known)))
    return page(known["name"], "a design by cdpr", banner(mood, escape(words)), links, parts, data)


def _table(rows: Sequence[tuple[str, ...]], *, numeric: bool = True) -> str:
    head, *body = [tuple(escape(cell) for cell in row) for row in rows]
    return table(body, head, numeric=numeric)


def _front(known: dict[str, Any]) -> str:
    rows = members(known)
    fold = " open" if len(rows) <= FEW_ROWS else ""
    inside = f"{_table(rows)}\n<p>Each is a robot file: front/NUMBER.yaml.</p>"
    return f"<h2>Pareto front</h2>\n<details{fold}><summary>{len(rows) - 1} robots</summary>\n{inside}</details>"


def _remarks(known: dict[str, Any]) -> str:
    texts = remarks(known)
    return f"\n<p>{escape('; '.join(texts))}.</p>" if texts else ""


def _robots(found: Designed, best: str) -> tuple[dict[str, Any] | None, list[str], list[str]]:
    """Return the player data, the figure of the best robot, and that of the initial robot."""
    before = _shown(found.design.robot)
    still = still_scene(before, f"{found.design.name}: before")
    stills = [figure("before", "Before", still, _caption(found.design.robot))]
    try:
        robot = found.robot(found.best)
    except CdprError:  # no candidate is a valid robot
        return None, [], stills
    shown, arrays = _shown(robot), Arrays()
    data = page_data(None, [scene(shown, arrays)], {}, arrays, (0.0, 0.0), [])
    still = still_scene(shown, f"{found.design.name}: {best}")
    return data, [figure("space", best.capitalize(), still, _caption(robot), live=viewer(data))], stills


def _shown(robot: Robot) -> Pictures:
    return pose_pictures(home_pose(robot)[0], Subject.of_robot(robot))


def _caption(robot: Robot) -> str:
    return f"{escape(robot.name)} in its home pose: {robot.m} cables, a platform of {robot.platform.mass:g} kg."


def _charts(found: Designed) -> tuple[list[str], dict[str, str]]:
    """Return the figures of the search, and their names for the navigation."""
    goals, name = found.design.section.wanted, found.design.name
    if len(goals) == 1:
        svg = convergence(found).markup(f"{name}: convergence")
        return [figure("search", "Convergence", svg, CONVERGED)], {"search": "Convergence"}
    drawn = []
    for k, (first, second) in enumerate(list(combinations(range(len(goals)), 2))[:PAIRS], 1):
        svg = pareto(found, first, second).markup(f"{name}: Pareto front {k}")
        drawn.append(figure(f"pareto-{k}", "Pareto front", svg, DOMINATED))
    return drawn, {"pareto-1": "Pareto"}


def _about(known: dict[str, Any]) -> str:
    optimizer = known["optimizer"]
    limits = "".join(f"<li><code>{escape(text)}</code></li>" for text in known["constraints"])
    kept = f"<p>Constraints:</p><ul>{limits}</ul>" if limits else "<p>No constraints.</p>"
    goals = "".join(f"<li><code>{escape(text)}</code></li>" for text in known["goals"])
    versions = ", ".join(f"{name} {version}" for name, version in known["versions"].items())
    return (
        f"<h2>About</h2>\n<p>Goals:</p><ul>{goals}</ul>{kept}"
        f"<p>{escape(optimizer['type'])}, seed {optimizer['seed']}: {known['candidates']} candidates, "
        f"{known['refused']} of them refused. One that keeps all constraints is better than one that does not; of two "
        "that do not, the one that violates them less (Deb 2000).</p>\n"
        f"<p>Robot: {escape(known['robot'])}. Versions: {escape(versions)}.</p>"
    )
