"""Write the tables of thesis.md: figures published in the thesis's chapter 6 beside ours.

    cdpr study scenarios/studies/thesis_ch6.yaml --jobs 2 --out out/thesis
    cdpr study scenarios/studies/thesis_belief.yaml --jobs 2 --out out/belief
    python docs/thesis.py out/thesis out/belief

keeps the studies' results, and those of runs with properties of the thesis's program that no scenario can express
(gazebo_legs.py), in thesis.csv, and writes the tables. Of a study whose folder is not given what is there is kept; with
none the tables alone are written. A test holds both.
"""

from __future__ import annotations

import csv
import itertools
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from gazebo_legs import GazeboLegs, OrLowest, Playback
from marked import rewritten, table

from cdpr.analysis.study.plan import StudyCase, load_study
from cdpr.base.errors import SimulationStopped
from cdpr.log.run import Run
from cdpr.scenario import load_scenario
from cdpr.simulation.build import build
from cdpr.simulation.header import make_header
from cdpr.simulation.loop import Loop

HERE = Path(__file__).parent
STUDY, BELIEF = (HERE.parent / "scenarios" / "studies" / f"thesis_{name}.yaml" for name in ("ch6", "belief"))
PAGE, RESULTS = HERE / "thesis.md", HERE / "thesis.csv"

GAINS = (100, 800, 1200, 1500)
PUBLISHED = {
    "lp": (54, 456, 1224),
    "qp": (32, 110, 342),
    "pseudo_inverse": (117, 117, 117),
    "closed_form": (267, 385, 517),
}
NEAR = 1.5  # a row explains a figure if all three values are within this factor

AXES = ("block", "start", "backend", "geometry", "controlled", "solver", "gain")
RESULT = ("finished", "diverged")  # how a case may end
FIGURES = ("simulated_s", "position_error_max_m", "tension_min_N", "tension_max_N")
ASSUMPTIONS = {
    ("as_written", ""): "as written",
    ("off_the_start", "0.3 m below"): "start 0.3 m below",
    ("off_the_start", "0.4 m inwards"): "start 0.4 m inwards",
    ("off_the_start", "far away"): "start at [0, 0, 1.5] m",
    ("played_in_10_s", ""): "played in 10 s",
    ("held_10_ms", ""): "commands held 10 ms",
    ("friction", ""): "as written, with friction",
    ("friction", "0.3 m below"): "start 0.3 m below, with friction",
    ("one_step", ""): "one step per message",
    ("one_step", "0.3 m below"): "one step per message, start 0.3 m below",
    ("or_lowest", ""): "one step, infeasible: all at 1 N",
    ("or_lowest", "0.3 m inwards"): "one step, infeasible: all at 1 N, start 0.3 m inwards",
    ("moves_17_kg", ""): "17 kg, controller assumes 1 kg",
    ("moves_17_kg_held", ""): "17 kg, commands held 10 ms, played in 10 s",
    ("moves_17_kg_held_friction", ""): "17 kg, commands held 10 ms, with friction",
    ("moves_17_kg_one_step", ""): "17 kg, one step per message",
}


@dataclass(frozen=True)
class Plant:
    """A block of runs that no scenario can express; legs have friction in all of them."""

    starts: Sequence[str]
    solvers: Sequence[str] = tuple(PUBLISHED)
    messages: bool = False  # a command every 10 ms; the move is played in 10 s with the feed-forward of 100 s
    one_step: bool = False  # a command acts for one step of 1 ms
    or_lowest: bool = False  # where a solver has no answer, every cable is at its lower limit


PLANTS = {
    "friction": Plant(("", "0.3 m below")),
    "one_step": Plant(("", "0.3 m below"), messages=True, one_step=True),
    "or_lowest": Plant(("", "0.3 m inwards"), ("lp", "qp"), messages=True, one_step=True, or_lowest=True),
    "moves_17_kg_held_friction": Plant(("",), messages=True),
    "moves_17_kg_one_step": Plant(("",), messages=True, one_step=True),
}
# The studies, and which plants are run for all that the common axes of each vary.
PARTS = {
    STUDY: ("friction", "one_step", "or_lowest"),
    BELIEF: ("moves_17_kg_held_friction", "moves_17_kg_one_step"),
}
STARTS = {
    "": {},
    "0.3 m below": {"initial.position": [0, -2, 1.7]},
    "0.3 m inwards": {"initial.position": [0, -1.7, 2]},
}

Row = dict[str, str]


def points(study: Path) -> list[dict[str, Any]]:
    """Return the changes of each point of a study's common axes: geometry, controlled directions, solver."""
    return [axis["points"] for axis in yaml.safe_load(study.read_text())["axes"][:3]]


def plant_rows(study: Path) -> Iterator[Row]:
    """Run the plants of a study, for all that its common axes vary."""
    geometry, controlled, solver = points(study)
    for block in PARTS[study]:
        plant = PLANTS[block]
        for start, robot, dof, name, gain in itertools.product(
            plant.starts, geometry, controlled, plant.solvers, GAINS
        ):
            changes = {**STARTS[start], **geometry[robot], **controlled[dof], **solver[name]}
            run = plant_run(plant, {**changes, "controller.kp": gain, "controller.kd": gain})
            names = (block, start, "reference", robot, dof, name, str(gain))
            yield {**dict(zip(AXES, names, strict=True)), **figures(run)}


def plant_run(plant: Plant, changes: dict[str, Any]) -> Run:
    """Run the first 12 s of the study's scenario on a plant."""
    times = {"simulation.duration": 12.0, "simulation.control_step": 0.01 if plant.messages else 0.001}
    scenario = load_scenario(STUDY.parent.parent / "thesis_ch6.yaml", overrides={**times, **changes})
    parts = build(scenario)
    parts = replace(
        parts,
        backend=GazeboLegs(parts.backend, plant.one_step),  # type: ignore[arg-type]
        trajectory=Playback(parts.trajectory, 10.0 if plant.messages else 1.0),  # type: ignore[arg-type]
    )
    if plant.or_lowest:
        parts = replace(parts, solver=OrLowest(parts.solver), respects_bounds=False)  # type: ignore[arg-type]
    loop = Loop(parts)
    loop.warm_up(scenario.initial.state())
    rows = np.zeros((scenario.simulation.steps + 1, loop.row.size))
    status = "finished"
    try:
        loop.run(rows, lambda k: None)
    except SimulationStopped:
        status = "diverged"
    return Run(make_header(scenario), rows[: loop.count], status)


def figures(run: Run) -> Row:
    """Return the columns of a run in thesis.csv."""
    tension, error = run.tension, np.linalg.norm(run.position_error, axis=1)
    values = (float(run.time[-1]), float(error.max()), float(tension.min()), float(tension.max()))
    return {"status": run.status, **{name: f"{value:.5g}" for name, value in zip(FIGURES, values, strict=True)}}


def kept(row: Row) -> Row:
    """Return the columns of a row of the study's table in thesis.csv."""
    cells = {name: row.get(name) or "" for name in AXES}
    return {**cells, "status": row["status"], **{name: f"{float(row[name]):.5g}" for name in FIGURES}}


def results() -> list[Row]:
    """The rows of thesis.csv."""
    with RESULTS.open(newline="") as file:
        return list(csv.DictReader(file))


@lru_cache
def study_cases(study: Path = STUDY) -> tuple[StudyCase, ...]:
    """The cases of a study."""
    return load_study(study).cases


def stored(folder: Path, study: Path = STUDY) -> list[Row]:
    """Return a study's rows for thesis.csv; exit with a message if the folder has other content or lacks results."""
    path, remedy = folder / "table.csv", f"run: cdpr study scenarios/studies/{study.name} --out {folder}"
    try:
        with path.open(newline="") as file:
            rows = list(csv.DictReader(file))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise SystemExit(f"{path}: {error}; {remedy}") from None
    ids = [case.id for case in study_cases(study)]
    found = [row.get("case") for row in rows]
    if found != ids:
        known = len({*ids} & {*found})
        raise SystemExit(
            f"{path}: not the table of {study.name} as it is: of its {len(ids)} cases {known} are among the table's "
            f"{len(rows)}; give another folder, or {remedy}"
        )
    for row in rows:
        if row["status"] not in RESULT:
            raise SystemExit(f"{path}: case {row['case']} is {row['status']!r}; {remedy}")
    return [kept(row) for row in rows]


def find(rows: Sequence[Row], **wanted: str) -> list[Row]:
    """The rows of thesis.csv that have these cells, by gain."""
    found = [row for row in rows if all(row[name] == value for name, value in wanted.items())]
    return sorted(found, key=lambda row: int(row["gain"]))


def cell(rows: Sequence[Row], method: str = "") -> str:
    """Largest tensions at the four gains; bold where the three published ones are near."""
    text = " / ".join("†" if row["status"] != "finished" else f"{float(row['tension_max_N']):.0f}" for row in rows)
    return f"**{text}**" if method and rows and factor(rows, method) <= NEAR else text


def factor(rows: Sequence[Row], method: str) -> float:
    """By how much the largest tensions miss the published ones, at worst; inf where a run diverged."""
    if any(row["status"] != "finished" for row in rows[:3]):
        return float("inf")
    ratios = [float(row["tension_max_N"]) / figure for row, figure in zip(rows, PUBLISHED[method], strict=False)]
    return max(max(ratio, 1.0 / ratio) for ratio in ratios)


def comparison() -> str:
    """Published figures, and ours under each assumption."""
    rows = results()
    lines = [["**published**", "", "", *(" / ".join(map(str, PUBLISHED[name])) for name in PUBLISHED)]]
    robots = [(geometry, dof) for geometry in ("caroca", "cube") for dof in ("six", "three")]
    for ((block, start), label), (geometry, dof) in itertools.product(ASSUMPTIONS.items(), robots):
        same = {"block": block, "start": start, "geometry": geometry, "controlled": dof}
        cells = [cell(find(rows, **same, solver=name), name) for name in PUBLISHED]
        lines.append([label, geometry, dof, *cells])
    return table(["assumption", "geometry", "controlled", "LP", "QP", "pseudo-inverse", "closed form"], lines)


def engines() -> str:
    """The first 12 s as written, on each engine."""
    rows = [row for row in results() if row["block"] == "engines"]
    names = list(dict.fromkeys(row["backend"] for row in rows))
    lines = []
    for key in dict.fromkeys((row["geometry"], row["controlled"], row["solver"]) for row in rows):
        same = dict(zip(("geometry", "controlled", "solver"), key, strict=True))
        lines.append([*key, *(cell(find(rows, **same, backend=name)) for name in names)])
    return table(["geometry", "controlled", "solver", *(f"`{name}`" for name in names)], lines)


def nearest() -> str:
    """The assumption under which all three figures of a solver are least wrong."""
    rows, lines = results(), []
    for method in PUBLISHED:
        groups = []
        for (block, start), label in ASSUMPTIONS.items():
            for geometry, dof in itertools.product(("caroca", "cube"), ("six", "three")):
                same = {"block": block, "start": start, "geometry": geometry, "controlled": dof, "solver": method}
                group = find(rows, **same)
                if group:
                    groups.append((factor(group, method), f"{label}; {geometry}, {dof}", cell(group[:3])))
        wrong, label, values = min(groups)
        lines.append([method, " / ".join(map(str, PUBLISHED[method])), values, label, f"{wrong:.2f}"])
    return table(["solver", "published (N)", "ours (N)", "assumption", "largest error factor"], lines)


TABLES = {"comparison": comparison, "nearest": nearest, "engines": engines}


def updated(text: str) -> str:
    """The page with its tables written anew."""
    return rewritten(text, TABLES)


def study_of(folder: Path) -> Path:
    """Return the study of a folder: the first one unless its cases are those of another."""
    try:
        with (folder / "table.csv").open(newline="") as file:
            found = {row.get("case") for row in csv.DictReader(file)}
    except (OSError, UnicodeDecodeError, csv.Error):
        return STUDY
    return next((study for study in PARTS if found & {case.id for case in study_cases(study)}), STUDY)


def blocks(study: Path) -> set[str]:
    """The blocks of a study and its plants."""
    return {block["name"] for block in yaml.safe_load(study.read_text())["blocks"]}.union(PARTS[study])


def main(*folders: Path) -> None:
    """Keep what folders of the studies hold, if any are given, and write the tables."""
    if folders:
        fresh = {study_of(folder): folder for folder in folders}
        tables = {study: stored(folder, study) for study, folder in fresh.items()}  # reports errors before writing
        rows: list[Row] = []  # all of them before the old are overwritten
        for study in PARTS:
            if study in tables:
                rows += [*tables[study], *plant_rows(study)]
            else:
                rows += [row for row in results() if row["block"] in blocks(study)]
        with RESULTS.open("w", newline="") as file:
            writer = csv.DictWriter(file, [*AXES, "status", *FIGURES], lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)
    PAGE.write_text(updated(PAGE.read_text()))


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
