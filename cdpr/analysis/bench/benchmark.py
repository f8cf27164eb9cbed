"""Benchmark run: every solver on the problems of every robot."""

from __future__ import annotations

import contextlib
import platform
import warnings
from collections.abc import Callable, Collection, Mapping, Sequence
from functools import lru_cache
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np

from cdpr.analysis.bench import measures
from cdpr.analysis.bench.adversaries import adversaries as make_adversaries
from cdpr.analysis.bench.adversaries import robots as hard_robots
from cdpr.analysis.bench.continuity import Path
from cdpr.analysis.bench.oracle import Oracle, certified, consult
from cdpr.analysis.bench.problems import Problems, box, hard_problems, make_paths, make_problems
from cdpr.analysis.bench.solver_calls import SolverCallFailed, make_solver, run_solver, solve_one
from cdpr.base.errors import CdprError, PluginError
from cdpr.base.version import VERSION
from cdpr.model import Robot
from cdpr.model.robot import Array, read_only
from cdpr.plugins import PluginOptions
from cdpr.plugins.registry import Registered, Registry, registry
from cdpr.tension import Status

POSES, SEED = 500, 1
POSES_PER_PATH = 50  # poses per path

# Solvers that declare the property `slow` (milliseconds per call) get only one in SLOW poses and paths, but at least
# FEWEST poses and one path. The property is declared so that no figure depends on the machine's speed.
SLOW, FEWEST = 50, 10

ORACLE = 3  # cost of the oracle for one robot, in solvers, for the progress

LIBRARIES = ("numpy", "scipy", "daqp")  # libraries whose versions are always reported

Progress = Callable[[int, int], None]
Point = Callable[[Path, float], tuple[Array, Array]]


def run(
    robots: Sequence[Robot],
    solvers: Collection[str] | None = None,
    poses: int = POSES,
    seed: int = SEED,
    *,
    adversaries: int = 0,
    plugins: Registry | None = None,
    options: Mapping[str, Mapping[str, object]] | None = None,
    progress: Progress = lambda done, total: None,
) -> dict[str, Any]:
    """Run the benchmark and return all figures as plain data: lists, dictionaries, texts, numbers and None.

    A solver that is not installed, cannot be loaded, raises or does not support a robot has a row with the reason. An
    interrupt (Ctrl-C) ends the benchmark: the completed part is returned, marked as `interrupted`.

    Args:
        robots: at least one robot.
        solvers: names of solvers; all known ones by default.
        poses: problems per robot.
        seed: seed of poses, loads, paths and adversaries.
        adversaries: number of additional adversarial problems for each of several robot sizes, reported separately; see
            `cdpr.analysis.bench.adversaries`.
        plugins: registry of solvers; the installed ones by default.
        options: options by solver; defaults otherwise.
        progress: called with the finished steps and their total, first with 0.

    Raises:
        CdprError: if there is nothing to do.
        PluginError: if a solver is unknown, or scipy or daqp are missing.
    """
    found = plugins or registry()
    entries = {name: found.get("solver", name) for name in (found.names("solver") if solvers is None else solvers)}
    if not robots or not entries or poses < 1 or adversaries < 0:
        raise CdprError("a benchmark needs at least one robot, one solver and one pose")
    if strangers := sorted(set(options or {}) - set(entries)):
        raise PluginError(
            f"options for '{strangers[0]}', which is not among the selected solvers: {', '.join(entries)}"
        )
    chosen = {name: entry.read_options((options or {}).get(name, {})) for name, entry in entries.items()}
    foes = hard_robots() if adversaries else []
    steps, done = len(robots) * (len(entries) + ORACLE) + len(foes) * (len(entries) + 1), 0
    progress(done, steps)  # before the slow import of the solvers
    about = [_about(name, entry) for name, entry in entries.items()]
    usable = [name for name, row in zip(entries, about, strict=True) if not row["problem"]]
    result: dict[str, Any] = {
        "poses": poses,
        "seed": seed,
        "interrupted": False,
        "versions": _versions(entries),
        "solvers": about,
        "robots": [],
        "adversaries": [],
    }
    try:
        for robot in robots:
            problems = make_problems(robot, poses, seed)
            oracle = consult(problems, [str(row["properties"].get("objective")) for row in about if not row["problem"]])
            paths = make_paths(robot, max(1, poses // POSES_PER_PATH), seed)
            point = lru_cache(maxsize=None)(_point)  # shared by all solvers
            described = _describe(problems, oracle)
            result["robots"].append(described)
            done += ORACLE
            for name in entries:
                progress(done, steps)
                done += 1
                if name in usable:
                    described["results"].append(
                        {"solver": name, **_row(entries[name], chosen[name], problems, oracle, paths, point)}
                    )
        for robot in foes:
            progress(done, steps)
            found_hard = make_adversaries(robot, adversaries, seed)
            problems, oracle = hard_problems(found_hard), certified(found_hard)
            described = _describe(problems, oracle)
            result["adversaries"].append(described)
            done += 1
            for name in entries:
                progress(done, steps)
                done += 1
                if name in usable:
                    described["results"].append(
                        {"solver": name, **_row(entries[name], chosen[name], problems, oracle, (), _point)}
                    )
        progress(done, steps)
    except KeyboardInterrupt:
        result["interrupted"] = True
    return result


def _about(name: str, entry: Registered) -> dict[str, Any]:
    """Return the declared properties of a solver, and the reason if it cannot be used."""
    problem = ""
    try:
        entry.load()
    except PluginError as error:
        problem = str(error)
    info = entry.info
    return {
        "name": name,
        "summary": info.summary,
        # third-party plugins may declare values of any type
        "properties": {k: v if isinstance(v, (str, int, float, bool)) else str(v) for k, v in info.properties.items()},
        "distribution": entry.distribution,
        "version": entry.version,
        "problem": problem,
    }


def _describe(problems: Problems, oracle: Oracle) -> dict[str, Any]:
    robot = problems.robot
    feasible, infeasible = int(oracle.feasible.sum()), int(oracle.infeasible.sum())
    return {
        "name": robot.name,
        "n": robot.n,
        "m": robot.m,
        "redundancy": robot.m - robot.n,
        "tension_max_N": float(problems.t_max.max()),
        "box_m": box(robot).tolist(),
        "feasible": feasible,
        "infeasible": infeasible,
        "edge": int(oracle.edge.sum()),
        "undecided": len(problems) - feasible - infeasible - int(oracle.edge.sum()),
        "results": [],
    }


def _point(path: Path, s: float) -> tuple[Array, Array]:
    W, wrench = path.at(s)
    return read_only(W), read_only(wrench)


def _row(
    entry: Registered, options: PluginOptions, problems: Problems, oracle: Oracle, paths: Sequence[Path], point: Point
) -> dict[str, Any]:
    """Return the result of one solver on one robot; `outcome` is "measured", "unsupported" (the robot) or "failed"."""
    if entry.info.properties.get("slow"):
        count = max(min(FEWEST, len(problems)), len(problems) // SLOW)
        problems, oracle, paths = problems.first(count), oracle.first(count), paths[: max(1, len(paths) // SLOW)]
    # warnings of solvers are not measured
    with np.errstate(all="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            return _measured(entry, options, problems, oracle, paths, point)
        except SolverCallFailed as failure:
            return {"outcome": "failed", "detail": str(failure)}


def _measured(
    entry: Registered, options: PluginOptions, problems: Problems, oracle: Oracle, paths: Sequence[Path], point: Point
) -> dict[str, Any]:
    robot = problems.robot
    solver = make_solver(entry.load(), robot, options)
    answers = run_solver(solver, problems, poisoned=problems.limits is not None)
    if (answers.status == Status.UNSUPPORTED).all():
        return {"outcome": "unsupported", "detail": ""}

    def tension(path: Path, s: float) -> Array | None:
        status, t = solve_one(solver, *point(path, s), robot.tension_min, robot.tension_max)
        return t if status == Status.OK and np.isfinite(t).all() else None

    return {
        "outcome": "measured",
        "detail": "",
        **measures.accuracy(problems, oracle, answers, entry.info.properties),
        "jumps": measures.jumps(paths, tension),
        "time": measures.times(oracle, answers),
    }


def _versions(entries: dict[str, Registered]) -> dict[str, str]:
    """Return the versions of all software that computes: cdpr, Python, its libraries and those of the solvers."""
    versions = {"cdpr": VERSION, "python": platform.python_version()}
    brought = {name for entry in entries.values() for name in (entry.distribution, *entry.info.requires)}
    for name in sorted({*LIBRARIES, *brought} - {"cdpr"}):
        with contextlib.suppress(PackageNotFoundError):
            versions[name] = version(name)
    return versions
