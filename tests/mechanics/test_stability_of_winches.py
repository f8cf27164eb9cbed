"""The linearised robot uses only numbers that its winches declare."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from conftest import ROOT

import cdpr
from cdpr.base.errors import CdprError
from cdpr.base.fields import Positive
from cdpr.cables import MODELS
from cdpr.cables.chain import Chain, Number, Winch
from cdpr.mechanics import stability
from cdpr.plugins.registry import registry
from cdpr.simulation.build import check_cables

WINCH = ROOT / "scenarios" / "winch.yaml"
LONG = {"simulation.physics_step": 0.5, "simulation.control_step": 0.5, "robot.cable.model": "elastic"}


def use(monkeypatch, *numbers):
    """Let all cables have a winch with these numbers on a span that stretches."""
    chain = Chain(Winch(header="own.hpp", numbers=numbers, states=2), MODELS["elastic"].span)
    monkeypatch.setattr(stability, "chain_of", lambda robot, cable: chain)


def drum_numbers(*keys):
    return [number for number in MODELS["elastic"].winch.numbers if number.key in keys]


def test_friction_that_a_winch_does_not_declare_is_not_used(monkeypatch):
    scenario = cdpr.load_scenario(WINCH, overrides={"robot.cable.model": "elastic"})
    still = {"viscous_friction": 0.0, "coulomb_friction": 0.0}
    cables = tuple(replace(cable, winch=replace(cable.winch, **still)) for cable in scenario.robot.cables)
    state = scenario.initial.state()
    expected = stability.oscillator(replace(scenario.robot, cables=cables), state).C
    assert not np.array_equal(stability.oscillator(scenario.robot, state).C, expected)
    use(monkeypatch, *drum_numbers("drum_radius", "inertia"))
    assert np.array_equal(stability.oscillator(scenario.robot, state).C, expected)


def test_the_step_of_winches_without_a_drum_is_not_checked(monkeypatch):
    """Their numbers are not those of a drum: the stable step is unknown."""
    scenario = cdpr.load_scenario(WINCH, overrides=LONG)
    backend = registry().get("backend", "reference")
    with pytest.raises(CdprError, match=r"simulation\.physics_step 0\.5 s is too long"):
        check_cables(scenario, backend)
    use(monkeypatch, Number("winch.pitch", Positive, "m", "pitch of the screw"), *drum_numbers("inertia"))
    check_cables(scenario, backend)
