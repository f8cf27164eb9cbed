"""Write the README's generated parts: the tables of plugins, of solvers and of figures, and the picture.

Run: python docs/update_readme.py (the picture: python docs/update_readme.py --picture). A test holds the tables to it.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

from marked import rewritten

from cdpr.bench.overview import overview
from cdpr.plugins.registry import OWN_DISTRIBUTION, ROLES, registry
from cdpr.report.text.bench import OVERVIEW, overview_cells

ROOT = Path(__file__).parent.parent
README = ROOT / "README.md"
PICTURE = ROOT / "docs" / "caroca.svg"


def plugin_table() -> str:
    """Our own plugins, as the registry knows them."""
    lines = ["| role | name | what it is | options |", "|---|---|---|---|"]
    for role in ROLES:
        for name, entry in sorted(registry().plugins[role].items()):
            if entry.distribution == OWN_DISTRIBUTION:
                options = ", ".join(f"`{key}`" for key in entry.info.options.model_fields) or "none"
                lines.append(f"| {role} | `{name}` | {entry.info.summary} | {options} |")
    return "\n".join(lines)


def figure_table() -> str:
    """What benchmarks/figures.json says."""
    figures = json.loads((ROOT / "benchmarks" / "figures.json").read_text())
    lines = ["| figure | measured |", "|---|---|"]
    for backend, costs in figures["step"].items():
        lines.append(f"| closed-loop step on `{backend}`, log included | {costs['ratio']:.2f} pinv |")
        lines.append(f"| the same for CoGiRo, whose mass lies off the origin | {costs['ratio_cogiro']:.2f} pinv |")
        lines.append(
            f"| the same for caroca with 10 physics steps per control step | {costs['ratio_10_substeps']:.2f} pinv |"
        )
    startup = figures["startup"]
    lines += [
        f"| `cdpr --help` | {startup['help']:.2f} s CPU |",
        f"| `cdpr run`, 2 s on `reference`, without report | {startup['run']:.2f} s CPU |",
        f"| the same with report | {startup['run_report']:.2f} s CPU |",
        f"| compiling the kernels, once for an installation | {startup['compile'] - startup['cached']:.1f} s CPU |",
    ]
    return "\n".join(lines)


def solver_table() -> str:
    """What benchmarks/solvers.json says: the output of `cdpr bench solvers --json`."""
    figures = json.loads((ROOT / "benchmarks" / "solvers.json").read_text())
    lines = ["| solver | " + " | ".join(OVERVIEW) + " |", "|---" * (1 + len(OVERVIEW)) + "|"]
    for row in overview(figures):
        if found := overview_cells(row):
            lines.append(f"| `{row['name']}` | " + " | ".join(cell.replace("_", " ") for cell in found) + " |")
    return "\n".join(lines)


def updated(text: str) -> str:
    """The README with its tables written anew."""
    return rewritten(text, TABLES)


TABLES = {"plugins": plugin_table, "solvers": solver_table, "figures": figure_table}


def draw() -> None:
    """The picture: caroca, its cables and its path."""
    import cdpr
    from cdpr.report.figures.sketch import robot

    robot(cdpr.simulate(ROOT / "scenarios" / "caroca.yaml")).savefig(PICTURE, metadata={"Date": None})


if __name__ == "__main__":
    README.write_text(updated(README.read_text()))
    if "--picture" in sys.argv:
        draw()
