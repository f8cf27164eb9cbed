"""Draw the pictures of teaching.md and write its tables, from runs of the scenarios in this repository.

Run: python docs/teaching.py (a minute), or with the name of a table, such as `controllers`, only its runs. The figures
are in teaching.json; tests compare the tables with it, and the output of the page's commands with the tables.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from marked import rewritten, table
from teaching_controllers import SHOWN_CASE, controllers, cost_table, error_table
from teaching_runs import RESULTS, Figures, command, number, results, simulate
from teaching_vision import SCENARIO as VISION
from teaching_vision import SHOWN_CASE as SHOWN_VISION
from teaching_vision import vision, vision_table

from cdpr.log.run import Run
from cdpr.ui.report.figures.canvas import Axes, Chart, inline_svg, styled
from cdpr.ui.report.figures.surface import SUPERSCRIPT
from cdpr.ui.report.style import AXES, CABLES, INK, SOFT

HERE = Path(__file__).parent
PAGE = HERE / "teaching.md"
WIDTH = 7.6  # in

# Nine cables pull a box of 20 kg through their frame: solvers.
SOLVERS = {
    "pseudo_inverse": "smallest tensions (2-norm) without limits, then clipped to the limits",
    "qp": "smallest tensions (2-norm) within the limits",
    "analytic_centre": "tensions away from all limits",
    "maximin": "tensions as far as possible from the nearest limit",
}
NINE = {
    "robot": "robots/nine.yaml",
    "initial.position": [-0.3, 0.2, 1.8],
    "trajectory.to.position": [-0.2, 0.4, 1.3],
}
# CAROCA holds a pose, from 5 cm below it: gains, damped critically.
STIFFNESS = (25, 100, 400, 1600)
BELOW = {
    "simulation.duration": 2.0,
    "initial.position": [0, 0, 1.15],
    "trajectory": {"type": "hold", "position": [0, 0, 1.2]},
}
# The thesis's platform on legs that push, from 1 cm beside its pose: gain and control rate, Kp = Kd.
RATES = {"1 kHz": 0.001, "100 Hz": 0.01}
EQUAL_GAINS = (25, 50, 100, 150, 180, 190, 195, 205, 210, 220, 250, 300)
SHOWN = (150, 195, 205, 250)
BESIDE = {
    "simulation.duration": 3.0,
    "initial.position": [0, -0.99, 2],
    "trajectory": {"type": "hold", "position": [0, -1, 2]},
    "robot.unilateral": False,
    "robot.tension.min": -60000,
    "robot.tension.max": 66501,
}
LOST = 10.0  # m: off the picture
# CAROCA's move with one control period and several physics steps in it.
BACKENDS = ("reference", "mujoco", "bullet", "dart")
STEPS = (0.004, 0.002, 0.001, 0.0005)  # s
PERIOD, FINEST = 0.004, 0.0000625  # s
ENGINE_COLOURS = dict(zip(BACKENDS, (INK, *AXES), strict=True))


def solvers() -> tuple[Figures, Chart]:
    """One move, four ways to distribute the same wrench."""
    runs = {name: simulate("caroca.yaml", NINE, solver=name) for name in SOLVERS}
    found = {
        name: {
            "lowest_N": run.tension.min(),
            "highest_N": run.tension.max(),
            "jump_N": np.abs(np.diff(run.tension, axis=0)).max(),
            "error_mm": 1e3 * np.linalg.norm(run.position_error, axis=1).max(),
            "beyond": int(np.count_nonzero(run.solver_status)) / len(run.time),
        }
        for name, run in runs.items()
    }
    return found, draw_solvers(runs)


@styled
def draw_solvers(runs: Mapping[str, Run]) -> Chart:
    """All tensions of each run, with the limits."""
    chart = Chart(figsize=(WIDTH, 2.3))
    for k, (name, run) in enumerate(runs.items()):
        axes = chart.add_axes((0.075 + 0.235 * k, 0.2, 0.205, 0.66))
        axes.set_title(name, fontsize=8.5, loc="left")
        for i, colour in enumerate(CABLES):
            axes.plot(run.time[::20], run.tension[::20, i], color=colour, linewidth=1.0)
        for limit in (run.header.tension_min[0], run.header.tension_max[0]):
            axes.axhline(limit, color=SOFT, linestyle="--", linewidth=0.8)
        axes.set_ylim(0, 520)
        axes.tick_params(labelleft=k == 0)
        axes.set_xlabel("time (s)")
        if k == 0:
            axes.set_ylabel("tension (N)")
    return chart


def gain_changes(kp: int) -> Figures:
    """CAROCA's step with this gain, damped critically."""
    return {**BELOW, "controller.kp": kp, "controller.kd": 2 * kp**0.5}


def gains() -> tuple[Figures, Chart]:
    """The same step of 5 cm with four gains."""
    runs = {}
    for kp in STIFFNESS:
        runs[kp] = simulate("caroca.yaml", gain_changes(kp))
    found = {}
    for kp, run in runs.items():
        error = 1e3 * np.linalg.norm(run.position_error, axis=1)
        settled = float(run.time[np.flatnonzero(error > 1.0)[-1] + 1]) if error[-1] <= 1.0 else None
        found[str(kp)] = {"kd": 2 * kp**0.5, "settled_s": settled, "highest_N": run.tension.max()}
    return found, draw_gains(runs)


@styled
def draw_gains(runs: Mapping[int, Run]) -> Chart:
    """Error and largest tension over time."""
    chart = Chart(figsize=(WIDTH, 2.5))
    left, right = chart.add_axes((0.085, 0.18, 0.37, 0.74)), chart.add_axes((0.55, 0.18, 0.37, 0.74))
    for (kp, run), colour in zip(runs.items(), (*AXES, INK), strict=True):
        left.plot(run.time, 1e3 * np.linalg.norm(run.position_error, axis=1), color=colour, label=f"kp {kp}")
        right.plot(run.time[:500], run.tension.max(axis=1)[:500], color=colour)
    left.set_ylabel("position error (mm)")
    right.set_ylabel("largest tension (N)")
    for axes in (left, right):
        axes.set_xlabel("time (s)")
    left.legend(frameon=False, fontsize=8.5)
    return chart


def rate_changes(step: float, gain: int) -> Figures:
    """The thesis's platform beside its pose, with this control period, s, and gain."""
    return {**BESIDE, "simulation.control_step": step, "controller.kp": gain, "controller.kd": gain}


def rates() -> tuple[Figures, Chart]:
    """The error after 3 s, or where the run diverged, over the gain, at two control rates."""
    runs: dict[str, dict[int, Run]] = {}
    for name, step in RATES.items():
        runs[name] = {
            gain: simulate("thesis_ch6.yaml", rate_changes(step, gain), solver="pseudo_inverse") for gain in EQUAL_GAINS
        }
    found = {
        name: {
            str(gain): None if run.status == "diverged" else 1e3 * float(np.linalg.norm(run.position_error[-1]))
            for gain, run in group.items()
        }
        for name, group in runs.items()
    }
    return found, draw_rates(found, runs["100 Hz"])


@styled
def draw_rates(found: Figures, slow: Mapping[int, Run]) -> Chart:
    """The error at the end over the gain, and over time at the slow rate."""
    chart = Chart(figsize=(WIDTH, 2.6))
    left, right = chart.add_axes((0.095, 0.18, 0.37, 0.74)), chart.add_axes((0.58, 0.18, 0.37, 0.74))
    for (name, errors), colour in zip(found.items(), (AXES[2], AXES[0]), strict=True):
        y = [1e3 * LOST if error is None else max(error, 1e-9) for error in errors.values()]
        left.plot([int(gain) for gain in errors], y, color=colour, marker="o", markersize=3.5, label=name)
    left.axvline(2.0 / RATES["100 Hz"], color=SOFT, linestyle="--", linewidth=0.8)
    left.set_xlabel("gain Kp = Kd")
    left.set_ylabel("error after 3 s (mm)")
    left.legend(frameon=False, fontsize=8.5)
    for gain, colour in zip(SHOWN, (AXES[2], AXES[1], AXES[0], INK), strict=True):
        error = 1e3 * np.linalg.norm(slow[gain].position_error, axis=1)
        right.plot(slow[gain].time, error, color=colour, label=f"gain {gain}")
    right.set_xlabel("time (s), at 100 Hz")
    right.set_ylabel("error (mm)")
    right.legend(frameon=False, fontsize=8.5, loc="lower left")
    left.text(EQUAL_GAINS[-1], 2e3 * LOST, "diverged", color=AXES[0], ha="right")
    for axes in (left, right):
        axes.set_yscale("log")
        axes.minorticks_off()
        axes.set_ylim(1e-2, 1e5)
        power_ticks(axes.yaxis)
    return chart


def motion(backend: str, step: float) -> Run:
    """CAROCA's move on an engine with this physics step, s, under the one control period."""
    return simulate("caroca.yaml", step_changes(step), backend=backend)


def step_changes(step: float) -> Figures:
    """This physics step, s, under the one control period."""
    return {"simulation.control_step": PERIOD, "simulation.physics_step": step}


def steps_and_engines() -> tuple[Figures, Chart, Figures, Chart]:
    """Plot the error of each engine over the physics step, and the distances between engines over time."""
    truth = motion("reference", FINEST)
    runs = {(name, step): motion(name, step) for name in BACKENDS for step in STEPS}
    away = {
        name: {f"{1e3 * step:g}": 1e3 * apart(runs[name, step], truth).max() for step in STEPS} for name in BACKENDS
    }
    middle = {name: runs[name, 0.001] for name in BACKENDS}
    others = {
        name: {other: 1e3 * apart(middle[name], middle[other]).max() for other in BACKENDS if other != name}
        for name in BACKENDS
    }
    return away, draw_steps(away), others, draw_engines(middle)


def apart(a: Run, b: Run) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Distance of the platforms of two runs, (K,), m."""
    return np.asarray(np.linalg.norm(a.position - b.position, axis=1))


@styled
def draw_steps(away: Figures) -> Chart:
    """The largest error over the physics step."""
    chart = Chart(figsize=(0.6 * WIDTH, 2.7))
    axes: Axes = chart.add_axes((0.17, 0.17, 0.77, 0.77))
    for name, errors in away.items():
        looks = {"color": ENGINE_COLOURS[name], "marker": "o", "markersize": 3.5, "label": name}
        dashes = "-" if name in ("reference", "mujoco") else "--"
        axes.loglog([float(step) for step in errors], list(errors.values()), linestyle=dashes, **looks)
    axes.minorticks_off()
    power_ticks(axes.yaxis)
    axes.set_xticks([0.5, 1, 2, 4], ["0.5", "1", "2", "4"])
    axes.set_xlabel("physics step (ms)")
    axes.set_ylabel("largest error of position (mm)")
    axes.legend(frameon=False, fontsize=8.5, loc="center right")
    return chart


@styled
def draw_engines(runs: Mapping[str, Run]) -> Chart:
    """Distances over time, from the reference and among the engines."""
    chart = Chart(figsize=(0.6 * WIDTH, 2.7))
    axes: Axes = chart.add_axes((0.17, 0.17, 0.77, 0.77))
    time, dashes = runs["mujoco"].time, ("-", (0, (4, 3)), (0, (1.5, 2.5)))
    for name, dash in zip(BACKENDS[1:], dashes, strict=True):
        difference = 1e3 * apart(runs[name], runs["reference"])
        axes.semilogy(
            time[1::4], difference[1::4], color=ENGINE_COLOURS[name], linestyle=dash, label=f"{name}, reference"
        )
    for name in ("bullet", "dart"):
        difference = 1e3 * np.maximum(apart(runs[name], runs["mujoco"]), 1e-18)
        axes.semilogy(time[1::4], difference[1::4], color=ENGINE_COLOURS[name], linewidth=0.8, label=f"{name}, mujoco")
    axes.minorticks_off()
    power_ticks(axes.yaxis)
    axes.set_ylim(1e-16, 1e1)
    axes.set_xlabel("time (s)")
    axes.set_ylabel("distance of positions (mm)")
    axes.legend(frameon=False, fontsize=8.0, loc=(0.3, 0.36))
    return chart


def power_ticks(axis: Any) -> None:
    """Write powers of ten as our font can."""
    axis.set_major_formatter(lambda value, _: "10" + f"{np.log10(value):.0f}".translate(SUPERSCRIPT))


def solver_table() -> str:
    """Tensions and error of each solver."""
    rows = [
        [
            f"`{name}`",
            SOLVERS[name],
            f"{row['lowest_N']:.0f} to {row['highest_N']:.0f}",
            number(row["jump_N"]),
            number(row["error_mm"]),
            f"{100 * row['beyond']:.0f} %",
        ]
        for name, row in results()["solvers"].items()
    ]
    titles = ["solver", "selected tensions", "tensions (N)", "largest change in 1 ms (N)"]
    titles += ["largest position error (mm)", "control steps in which the solver violates a limit"]
    return table(titles, rows)


def gain_table() -> str:
    """Settling time and tension over the gain."""
    rows = [
        [
            kp,
            f"{row['kd']:g}",
            number(row["settled_s"]) if row["settled_s"] else "not in 2 s",
            f"{row['highest_N']:.0f}",
        ]
        for kp, row in results()["gains"].items()
    ]
    return table(["kp (1/s²)", "kd (1/s)", "time until the error stays below 1 mm (s)", "largest tension (N)"], rows)


def rate_table() -> str:
    """The error after 3 s over the gain."""
    found = results()["rates"]
    rows = [[str(gain), *(number(found[name][str(gain)]) for name in found)] for gain in SHOWN]
    return table(["gain Kp = Kd", *(f"error after 3 s, at {name} (mm)" for name in found)], rows)


def step_table() -> str:
    """The error over the physics step."""
    found = results()["steps"]
    rows = [[f"{1e3 * step:g}", *(number(found[name][f"{1e3 * step:g}"]) for name in found)] for step in STEPS]
    return table(["physics step (ms)", *(f"error of `{name}` (mm)" for name in found)], rows)


def engine_table() -> str:
    """The largest distance between each two engines."""
    found = results()["engines"]
    rows = [[f"`{a}`", *(number(found[a][b]) if a != b else "" for b in found)] for a in found]
    return table(["distance (mm)", *(f"`{name}`" for name in found)], rows)


# For each table, what gives one of its rows.
COMMANDS = {
    "solvers": lambda: command("run", "caroca.yaml", NINE, solver="maximin"),
    "gains": lambda: command("run", "caroca.yaml", gain_changes(400)),
    "rates": lambda: command("run", "thesis_ch6.yaml", rate_changes(RATES["1 kHz"], 205), solver="pseudo_inverse"),
    "steps": lambda: command("compare", "caroca.yaml", step_changes(0.002), backends="reference,mujoco"),
    "engines": lambda: command("compare", "caroca.yaml", step_changes(0.001), backends=",".join(BACKENDS)),
    "controllers": lambda: command("run", "caroca.yaml", SHOWN_CASE, controller="sliding_mode"),
    "vision": lambda: command("run", VISION, SHOWN_VISION),
}
TABLES = {
    "solvers": solver_table,
    "gains": gain_table,
    "rates": rate_table,
    "steps": step_table,
    "engines": engine_table,
    "controllers": error_table,
    "costs": cost_table,
    "vision": vision_table,
}
LABELS = {
    "solvers": "Tensions of the same move by four solvers",
    "gains": "Position error and largest tension for four gains",
    "rates": "Error over the gain at two control rates",
    "steps": "Error over the physics step on four engines",
    "engines": "Distance between engines over time",
}


def updated(text: str) -> str:
    """The page with its tables written anew."""
    return rewritten(text, {**TABLES, **{f"command of {name}": text for name, text in COMMANDS.items()}})


def main(only: Sequence[str]) -> None:
    """Run, draw and write; only some experiments, if they are given."""
    found, charts = {}, {}
    if not only or "solvers" in only:
        found["solvers"], charts["solvers"] = solvers()
    if not only or "gains" in only:
        found["gains"], charts["gains"] = gains()
    if not only or "rates" in only:
        found["rates"], charts["rates"] = rates()
    if not only or {"steps", "engines"} & set(only):
        found["steps"], charts["steps"], found["engines"], charts["engines"] = steps_and_engines()
    if not only or "controllers" in only:
        found["controllers"] = controllers()
    if not only or "vision" in only:
        found["vision"] = vision()
    plain = json.loads(json.dumps(found, default=float), parse_float=lambda text: float(f"{float(text):.5g}"))
    RESULTS.write_text(json.dumps({**results(), **plain}, indent=1) + "\n")
    for name, chart in charts.items():
        (HERE / f"teaching_{name}.svg").write_text(inline_svg(chart, name, LABELS[name]) + "\n")
    PAGE.write_text(updated(PAGE.read_text()))


if __name__ == "__main__":
    main(sys.argv[1:])
