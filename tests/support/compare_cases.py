"""Comparisons without worker processes, for tests of what is judged."""

from __future__ import annotations

import dataclasses

import numpy as np
import yaml
from conftest import ROOT
from plants import installed
from pydantic import ValidationError

import cdpr
from cdpr.analysis.compare.comparison import compare
from cdpr.analysis.compare.engines import field
from cdpr.analysis.compare.job import summarise
from cdpr.analysis.compare.runs import RunResult, Runs
from cdpr.base.errors import CdprError
from cdpr.plugins.registry import registry

SCENARIOS = ROOT / "scenarios"
SCHEME = "backend_options.reference.scheme"


def usable(name):
    """Return True if it is installed and requires no options for its plant."""
    entry = registry().get("backend", name)
    try:
        entry.info.options()
    except ValidationError:
        return False
    return not entry.missing


INSTALLED = {name for name in registry().names("backend") if usable(name)}
ENGINES = installed("mujoco", "bullet", "dart")

# Different possible faults of engines: space, a plane, a point; mass off the origin; axes turned; pushes; a broken
# cable; gains that forgive nothing.
SOUND = (
    "caroca",
    "planar",
    "point_mass",
    "off_centre_mass",
    "rotated_start",
    "external_wrench",
    "cable_break",
    "high_gains",
)


class Here(Runs):
    """Makes the runs in this process."""

    def __init__(self, scenario):
        super().__init__(scenario, None, 1, None, lambda done, total: None)
        self._made = {}

    def __getitem__(self, wanted):
        return self._made[self._canonical(wanted)]

    def make(self, wanted):
        for one in map(self._canonical, wanted):
            if one not in self._made:
                self._made[one] = self._one(one)

    def _one(self, wanted):
        try:
            run = cdpr.simulate(self.scenario, overrides=wanted.changes(self.scenario))
        except CdprError as error:
            run = error.run if isinstance(error.run, cdpr.Run) and len(error.run.rows) else None
            complete = run is not None and run.status in ("infeasible", "diverged")
            return RunResult(
                run if complete else None, run.status if complete else "failed", str(error), run is not None
            )
        return RunResult(run, "finished", "")


def load(name, changes=()):
    return cdpr.load_scenario(SCENARIOS / f"{name}.yaml", overrides=changes)


def shrunk(name, length, mass):
    """The first 0.2 s of a scenario with its robot and its path `length` times as long, the platform of `mass`, kg."""
    plain = yaml.safe_load(load(name, {"simulation.duration": 0.2}).resolved_yaml())
    robot, platform = plain["robot"], plain["robot"]["platform"]
    share = mass / platform["mass"]

    def scale(section, key, by):
        section[key] = (np.array(section[key]) * by).tolist()

    scale(platform, "inertia", share * length**2)
    scale(platform, "center_of_mass", length)
    platform["mass"] = mass
    for cable in robot["cables"]:
        scale(cable, "frame", length)
        scale(cable, "platform", length)
    for end in ("min", "max"):
        scale(robot["tension"], end, share)
    for section in (plain["initial"], plain["trajectory"]["from"], plain["trajectory"]["to"]):
        scale(section, "position", length)
    return cdpr.load_scenario(SCENARIOS / f"{name}.yaml", text=yaml.safe_dump(plain))


def comparison(name, backends=None, changes=(), solvers=()):
    """Groups of a comparison made here, and the figures of all."""
    scenario = load(name, changes)
    chosen = field(scenario, backends)
    groups = compare(Here(scenario), chosen, list(solvers) or [scenario.solver.type], named=backends is not None)
    facts = {"scenario": name, "duration_s": 1.0, "control_step_s": 1e-3, "physics_step_s": 1e-3}
    facts |= {"judge": {"backend": chosen.judge.name, "order": chosen.judge.order}, "absent": chosen.absent}
    return summarise(facts, groups, {})


def off(run, name, by, when=slice(100, None)):
    """The run with one field moved from a time on."""
    rows = run.rows.copy()
    block = rows[:, run.header.layout.columns[name]]
    (block if run[name].ndim > 1 else block[:, 0])[when] += by
    return dataclasses.replace(run, rows=rows)
