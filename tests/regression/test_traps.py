"""Detection of the stepping traps of engines.

The conformance kit checks an adapter by itself, the guards at every step of every run, `cdpr compare` at closed loops
beside the judge.
"""

from __future__ import annotations

import pytest
from cdpr_traps import TrapOptions
from cdpr_traps.backend import TRAPS, Wrapped, make
from compare_cases import ENGINES, SOUND, comparison, load
from spread import sampled

import cdpr
from cdpr.base.errors import Diverged
from cdpr.testing import check_factory
from cdpr.ui.report.text.compare import LIMIT_ALONE, notes

# Trap: the checks of the kit that must fail; whether the guards end a run in which it acts; whether a comparison fails.
CAUGHT = {
    "none": ((), False, False),
    "frame": (("state_is_current", "tumbling_keeps_energy_and_momentum"), False, True),
    "damping": (("coasting_keeps_velocity", "long_fall"), False, True),
    "clamp": (("long_fall",), False, False),
    "persistence": (("wrench_ends",), False, True),
    "lag": (("state_is_current",), False, True),
    "auto_reset": (("nan_shows", "huge_wrench_shows"), True, False),
    "dropped_nan": (("nan_shows",), False, False),
    "gravity": (("gravity_pulls", "long_fall", "hovers_in_balance"), False, True),
    "light_damping": (("coasting_keeps_velocity", "long_fall", "tumbling_keeps_energy_and_momentum"), False, True),
    "late": (("wrench_ends",), False, True),
}

# The kit's checks that any trap fails: what "none" must pass.
STEPPING = sorted({check for checks, *_ in CAUGHT.values() for check in checks})

# A turned platform with its mass off the origin; pushes that end.
LOOPS = {"rotated_start": {"simulation.duration": 0.5}, "external_wrench": {"simulation.duration": 2.0}}

pytestmark = pytest.mark.usefixtures("traps_plugin")


def trapped(trap, engine, **changes):
    return {"backend_options.traps.trap": trap, "backend_options.traps.engine": engine, **changes}


def by_comparison(trap, engine):
    found = [comparison(name, ["traps"], trapped(trap, engine, **changes)) for name, changes in LOOPS.items()]
    return [row for each in found for group in each.figures["groups"] for row in group["engines"]]


def test_every_trap_is_in_the_table():
    assert set(CAUGHT) == set(TRAPS)
    assert all(any(by) for trap, by in CAUGHT.items() if trap != "none")
    assert {trap for trap, (*_, compare) in CAUGHT.items() if compare} >= {"frame", "damping", "lag", "persistence"}


@pytest.mark.slow
@pytest.mark.parametrize("trap", CAUGHT)
def test_kit(trap):
    results = check_factory("backend", make, options=TrapOptions(engine="reference", trap=trap), only=STEPPING)
    assert {result.id for result in results if result.outcome == "failed"} >= set(CAUGHT[trap][0])
    assert bool(CAUGHT[trap][0]) is any(result.outcome == "failed" for result in results)


# An extreme load for one step: the reset restores the state completely.
SHOVE = [{"type": "wrench", "time": 0.1, "duration": 0.001, "force": [1e12, 0, 0]}]


@pytest.mark.parametrize("trap", CAUGHT)
def test_guards(trap):
    """Only a silent reset shows in a run by itself."""
    changes = trapped(trap, "mujoco", **{"simulation.duration": 0.3})
    if trap == "auto_reset":
        changes["events"] = SHOVE
    scenario = load("caroca", changes)
    if CAUGHT[trap][1]:
        with pytest.raises(Diverged, match="reset itself"):
            cdpr.simulate(scenario, backend="traps")
    else:
        assert cdpr.simulate(scenario, backend="traps").status == "finished"


@sampled(
    lambda trap, engine: trap in ("none", "frame"),
    ("trap", "engine"),
    [
        pytest.param(trap, engine, marks=() if engine == ENGINES[0] else pytest.mark.slow)
        for trap in CAUGHT
        for engine in ENGINES
    ],
)
def test_comparison(trap, engine):
    outcomes = {row["outcome"] for row in by_comparison(trap, engine)}
    assert ("disagrees" in outcomes) is CAUGHT[trap][2], outcomes
    assert outcomes <= {"agrees", "disagrees"}


@pytest.mark.slow
@pytest.mark.parametrize(("trap", "caught"), [("none", False), ("damping", True)])
def test_by_order_alone(trap, caught):
    """A fault that does not shrink with the step shows without any knowledge of the scheme."""
    (group,) = comparison(
        "rotated_start",
        ["traps"],
        trapped(trap, "mujoco", **{"backend_options.traps.scheme": "", "simulation.duration": 0.5}),
    ).figures["groups"]
    (row,) = group["engines"]
    assert row["standard"] == "order"
    assert (row["outcome"] == "disagrees") is caught, row


class Late(Wrapped):
    """Commands act one step late."""

    last = None

    def loads(self):
        now = self.command.copy(), self.external.copy()
        loads, self.last = self.last or now, now
        return loads


class Friction(Wrapped):
    """A friction of 1e-4 1/s."""

    def after(self):
        state = self.inner.state.copy()
        state[7:] *= 1.0 - 1e-4 * self.physics_step
        self.put(state)


@sampled(1, "fault", [Late, Friction])
def test_unmeasurable_orders_are_reported_and_schemes_judged(monkeypatch, fault):
    monkeypatch.setitem(TRAPS, "none", fault)
    for scheme, outcome in (("", "agrees"), ("semi_implicit_euler", "disagrees")):
        changes = trapped("none", "mujoco", **{"backend_options.traps.scheme": scheme, "simulation.duration": 0.3})
        (row,) = comparison("rotated_start", ["traps"], changes).figures["groups"][0]["engines"]
        assert row["outcome"] == outcome, row
        assert (LIMIT_ALONE in notes(row)) is (scheme == "")


@sampled(2, "name", SOUND)
def test_sound_engines_agree(name):
    """All installed engines, a second of each scenario and what happens in it."""
    seconds = {"external_wrench": 2.5, "cable_break": 1.2}.get(name, 1.0)
    figures = comparison(name, ENGINES, {"simulation.duration": seconds}).figures
    assert figures["agrees"] is True, figures
    assert len(figures["groups"][0]["engines"]) == len(ENGINES)
