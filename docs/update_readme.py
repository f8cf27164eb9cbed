"""Write the generated parts of README.md and docs/: plugins, checks of plugins, solvers and figures.

Run: python docs/update_readme.py. A test holds the pages to it. The README's picture is drawn by docs/picture.py.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

from marked import rewritten, table

from cdpr.analysis.bench.overview import overview
from cdpr.plugins.registry import OWN_DISTRIBUTION, ROLES, registry
from cdpr.testing.check import Check
from cdpr.testing.kit import BACKEND, CONTROLLER, ESTIMATOR, SOLVER
from cdpr.ui.report.text.bench import OVERVIEW, overview_cells

ROOT = Path(__file__).parent.parent
DOCS = ROOT / "docs"


def plugin_table(role: str) -> str:
    """Return the table of our own plugins with this role, as the registry knows them."""
    rows = [
        (f"`{name}`", entry.info.summary, ", ".join(f"`{key}`" for key in entry.info.options.model_fields))
        for name, entry in sorted(registry().plugins[role].items())
        if entry.distribution == OWN_DISTRIBUTION
    ]
    return table(("name", "description", "options"), rows)


def check_table(checks: Sequence[Check[Any]]) -> str:
    """Return the table of checks of the conformance kit: their names and docstrings."""
    return table(("check", "requirement"), ((f"`{check.id}`", check.description) for check in checks))


def step_table() -> str:
    """Return the table of the step in benchmarks/figures.json."""
    steps = json.loads((ROOT / "benchmarks" / "figures.json").read_text())["step"]
    keys = ("ratio", "ratio_in_memory", "ratio_python_controller", "ratio_cogiro", "ratio_10_substeps")
    titles = ("backend", "caroca", "without a log", "controller in Python", "CoGiRo", "10 physics steps")
    return table(titles, ((f"`{name}`", *(f"{costs[key]:.2f}" for key in keys)) for name, costs in steps.items()))


def figure_table() -> str:
    """Return the table of the other times in benchmarks/figures.json."""
    figures = json.loads((ROOT / "benchmarks" / "figures.json").read_text())
    rows, startup = figures["distribute"], figures["startup"]
    lines = [
        ("`cdpr.distribute` with `qp`, one wrench", f"{rows['row']:.3f} pinv"),
        ("the same, if a tension is at a limit", f"{rows['row_at_limits']:.3f} pinv"),
    ]
    for name, row in figures["rollout"].items():
        lines += [
            (
                f"`cdpr.rollout`, one step of one case; the cases differ in {name}",
                f"{row['row_without_set_up']:.3f} pinv",
            ),
            ("the same, preparation of one case", f"{row['set_up']:.0f} pinv"),
        ]
    lines += [
        ("`cdpr --help`", f"{startup['help']:.2f} s"),
        ("`cdpr run` of 2 s on `reference`, without report", f"{startup['run']:.2f} s"),
        ("the same with report", f"{startup['run_report']:.2f} s"),
    ]
    return table(("task", "computing time"), lines)


def step_cost() -> str:
    """Return the cost of a step, in a sentence."""
    steps = json.loads((ROOT / "benchmarks" / "figures.json").read_text())["step"]
    first, *_, last = sorted(steps, key=lambda backend: steps[backend]["step_us"])
    return (
        f"For a robot with eight cables, one control step takes {steps[first]['step_us']:.1f} us (`{first}`) "
        f"to {steps[last]['step_us']:.1f} us (`{last}`),\nincluding the log ([docs/figures.md](docs/figures.md))."
    )


def solver_table() -> str:
    """Return the table of benchmarks/solvers.json, the output of `cdpr bench solvers --json`."""
    figures = json.loads((ROOT / "benchmarks" / "solvers.json").read_text())
    lines = ["| solver | " + " | ".join(OVERVIEW) + " |", "|---" * (1 + len(OVERVIEW)) + "|"]
    for row in overview(figures):
        if found := overview_cells(row):
            lines.append(f"| `{row['name']}` | " + " | ".join(cell.replace("_", " ") for cell in found) + " |")
    return "\n".join(lines)


PAGES = {
    "../README.md": {"step": step_cost},
    "plugin_list.md": {f"{role}s": partial(plugin_table, role) for role in ROLES},
    "plugin_checks.md": {
        "checks of solvers": partial(check_table, SOLVER),
        "checks of controllers": partial(check_table, CONTROLLER),
        "checks of estimators": partial(check_table, ESTIMATOR),
        "checks of backends": partial(check_table, BACKEND),
    },
    "solvers.md": {"solvers": solver_table},
    "figures.md": {"steps": step_table, "figures": figure_table},
}


def updated(name: str) -> str:
    """A page with its tables written anew."""
    return rewritten((DOCS / name).read_text(), PAGES[name])


if __name__ == "__main__":
    for page in PAGES:
        (DOCS / page).write_text(updated(page))
