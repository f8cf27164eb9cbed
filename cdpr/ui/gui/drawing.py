"""Conversion of simulation data for the page: the scene once, then frames and curves; a frame needs only one row."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from cdpr.log.event import Event
from cdpr.log.run import Run
from cdpr.model import rotations
from cdpr.model.robot import Array
from cdpr.scenario import Scenario
from cdpr.scenario.events import ScenarioEvent, broken
from cdpr.scene import Pictures, pictures
from cdpr.scene.pictures import weight_range
from cdpr.simulation.header import make_header
from cdpr.ui.gui.curves import json_values
from cdpr.ui.report.player.arrays import Arrays
from cdpr.ui.report.player.scenes import scene
from cdpr.ui.report.plots.pictures import pictures_of

DECIMALS = 6  # of lengths and attitudes in frames, m: far below screen resolution
SEEN = 1e-3  # relative to the characteristic length: cable exits that move less are not redrawn
CURVE_POINTS = 17  # of a sagging cable
DECIMALS_N = 3  # of tensions and forces, N


class Drawing:
    """Converter of rows of a scenario's simulation.

    Attributes:
        header: header of the run.
        columns: number of columns and of decimals of each curve.
        range: smallest and largest tension (N) of taut cables, for their colours; an estimate until tensions are known.
    """

    def __init__(self, scenario: Scenario) -> None:
        self._scenario, self.header = scenario, make_header(scenario)
        self._events: tuple[Event, ...] = ()
        header, m = self.header, scenario.robot.m
        self.columns = {
            "tension": (m, DECIMALS_N),
            "position_error": (1, 9),
            "attitude_error": (1, 9),
            "length": (m, 6),
        }
        self.range = weight_range(header.subject, header.mass * float(np.linalg.norm(header.gravity)))
        self._known = False
        self._outlined: tuple[Array, list[Any]] | None = None  # cable exits, and their outlines

    def change(self, events: Sequence[ScenarioEvent]) -> None:
        """Update the events: broken cables, and the time after which limits differ from the robot's."""
        header = self.header
        self.header = replace(header, broken=broken(events, header.cables, header.control_step))
        self._events = tuple(Event(event.time, event.type, "") for event in events)

    def scene(self, state: Array, desired: Array) -> dict[str, Any]:
        """Return the scene with the platform at a state (13,) and desired state (19,), before the first step."""
        header, arrays, simulation = self.header, Arrays(), self._scenario.simulation
        drawn = scene(self._at(state, desired), arrays, self._scenario.name)
        path = np.array(header.path)
        low, high = drawn["bounds"]
        drawn["bounds"] = [np.minimum(low, path.min(axis=0)).tolist(), np.maximum(high, path.max(axis=0)).tolist()]
        return {
            "kind": "scene",
            "scene": {**drawn, "range": list(self.range)},
            "path": path.tolist(),
            "bytes": arrays.text(),
            "duration": simulation.steps * simulation.control_step,
            "step": simulation.control_step,
            "limits": in_json(header.tension_min, header.tension_max),
            "base": self._base(),
        }

    def _base(self) -> list[float] | None:
        """Return the rotation matrix from base to world axes, row by row; None if they coincide."""
        frame = self._scenario.sections.robot.frame
        return None if frame is None else rotations.matrix(frame.attitude).ravel().tolist()

    def still(self, state: Array, desired: Array) -> dict[str, Any]:
        """Return the frame of a state (13,) and desired state (19,) without tensions."""
        return self._frame(-1, self._at(state, desired))

    def frame(self, n: int, row: Array) -> dict[str, Any]:
        """Return the frame of the complete sample n, computed from its row (width,) only."""
        return self._frame(n, pictures_of(Run(self.header, row[None], "running", events=self._events)))

    def curves(self, rows: Array) -> Array:
        """Return time and curves of rows (n, width) in columns, and update the range of tensions."""
        run = Run(self.header, rows, "running")
        with np.errstate(all="ignore"):  # a diverged run is drawn as far as possible
            errors = [np.linalg.norm(error, axis=1) for error in (run.position_error, run.orientation_error)]
        self._learn(run.cable_tension)
        return np.column_stack([run.time, run.cable_tension, *errors, run.length])

    def _at(self, state: Array, desired: Array) -> Pictures:
        where = (desired[None, :3], desired[None, 3:7])
        return pictures(self.header.subject, np.zeros(1), state[None, :3], state[None, 3:7], desired=where)

    def _frame(self, n: int, shown: Pictures) -> dict[str, Any]:
        assert shown.desired_position is not None
        assert shown.desired_orientation is not None
        frame: dict[str, Any] = {
            "kind": "frame",
            "n": n,
            "t": round(float(shown.time[0]), DECIMALS),
            "p": _short(shown.position[0]),
            "q": _short(shown.orientation[0]),
            "dp": _short(shown.desired_position[0]),
            "dq": _short(shown.desired_orientation[0]),
            "tension": None if shown.tension is None else json_values(np.round(shown.tension[0], DECIMALS_N)),
            "state": None if shown.state is None else shown.state[0].tolist(),
            "force": [0.0, 0.0, 0.0] if shown.force is None else json_values(np.round(shown.force[0], DECIMALS_N)),
            "range": list(self.range),
        }
        if shown.subject.exits:
            ends = shown.ends[0]
            frame["exits"] = _short(ends[:, 0].ravel())
            frame["outlines"] = self._outlines(shown, ends)
        if shown.readings:
            frame["sensors"] = {name: _short(values[0]) for name, values in shown.readings.items()}
        if shown.unwound is not None:
            frame["curves"] = _short(shown.cable_lines(CURVE_POINTS)[0, :, 1:-1].ravel())
        return frame

    def _outlines(self, shown: Pictures, ends: Array) -> list[Any]:
        """Return the outlines of the cable exits; reuse the last ones if the exits have moved invisibly little."""
        if (
            self._outlined is None
            or np.abs(ends[:, 0] - self._outlined[0]).max() > SEEN * self.header.characteristic_length
        ):
            lines = [np.round(line, DECIMALS).tolist() for line in shown.subject.exit_lines(ends)]
            self._outlined = ends[:, 0].copy(), lines
        return self._outlined[1]

    def _learn(self, tension: Array) -> None:
        """Extend the colour range to the tensions of taut cables."""
        pulling = tension[np.isfinite(tension) & (tension > 0.0)]
        if pulling.size:
            low, high = float(pulling.min()), float(pulling.max())
            self.range = (min(low, self.range[0]), max(high, self.range[1])) if self._known else (low, high)
            self._known = True


def _short(values: Array) -> Any:
    return json_values(np.round(values, DECIMALS))


def in_json(low: Sequence[float], high: Sequence[float]) -> dict[str, list[float | None]]:
    """Return tension limits, N, for the page; None for infinite ones, which have no JSON form."""
    both = {"tension_min": low, "tension_max": high}
    return {name: [each if math.isfinite(each) else None for each in values] for name, values in both.items()}
