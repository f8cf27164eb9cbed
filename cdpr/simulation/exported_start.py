"""Start of exported plants: state of the platform, unwound lengths and tensions of its winches."""

from __future__ import annotations

from contextlib import ExitStack
from typing import NamedTuple

import numpy as np

from cdpr.base.defaults import BACKEND
from cdpr.cables import takes_lengths
from cdpr.cables.tables import command_kinds
from cdpr.log.blocks import BLOCK
from cdpr.model.robot import Array
from cdpr.scenario import Scenario
from cdpr.simulation.build import build
from cdpr.simulation.exported_winding import holding_tensions, start_lengths
from cdpr.simulation.loop import Loop
from cdpr.simulation.resting_start import warm_up


class ExportedStart(NamedTuple):
    """Start of an exported plant.

    Attributes:
        state: (13,), in the layout of `cdpr.model`.
        unwound: (m,), m, unwound lengths of winches that take lengths or rates; of others their tensions, N. None if
            all winches take tensions.
        tension: (m,), N, tensions by which the solver holds the platform; None likewise.
    """

    state: Array
    unwound: Array | None = None
    tension: Array | None = None


def exported_start(scenario: Scenario) -> ExportedStart:
    """Return the start of a scenario: its initial pose or, with `initial.equilibrium`, the pose of rest.

    Raises:
        CdprError: if no stable pose of rest is found, or a cable has no unwound length at the initial pose.
    """
    winds = takes_lengths(scenario.robot)
    if scenario.initial.equilibrium:
        return _at_rest(scenario, winds)
    if not winds:
        return ExportedStart(scenario.initial.state())
    tension = holding_tensions(scenario)
    return ExportedStart(scenario.initial.state(), start_lengths(scenario, tension), tension)


def _at_rest(scenario: Scenario, winds: bool) -> ExportedStart:
    """Return the start of a run, which the first sample of its loop contains."""
    own = scenario.with_changes({"simulation.backend": BACKEND})
    with ExitStack() as opened:
        parts = build(own)
        opened.callback(parts.controller.close)
        opened.callback(parts.backend.close)
        loop = Loop(parts)
        opened.callback(loop.close)
        warm_up(loop, own)
        with loop.timed():
            loop.begin(np.zeros((BLOCK, len(loop.row))), BLOCK)
            loop.decide()
        state = loop.state.copy()
        if not winds:
            return ExportedStart(state)
        tension = (loop.winding.start if loop.winding.needs_start else loop.tension).copy()
        lengths = loop.present.view("unstretched_length")
        return ExportedStart(state, np.where(command_kinds(own.robot) == 0, tension, lengths), tension)
