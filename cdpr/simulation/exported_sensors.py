"""Sensors and estimator of an exported plant with controller: the operations of a run on arrays of the export."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, NamedTuple, cast

import numpy as np
from numpy.typing import ArrayLike

from cdpr.base.column import Column
from cdpr.base.errors import CdprError
from cdpr.fmu.export.control import PAID_OUT, PULLS
from cdpr.log.layout import Layout
from cdpr.model.robot import Array, read_only
from cdpr.native.bind import bind
from cdpr.native.exported_pipeline import ESTIMATE, FINITE, IGNORED, Call, address, members
from cdpr.plugins import Backend, Controller, ControllerInputs
from cdpr.scenario import Scenario
from cdpr.sensing.sensor import measuring
from cdpr.simulation.columns import columns_of
from cdpr.simulation.controller_calls import observes
from cdpr.simulation.loop_part import LoopPart, Surroundings, writes
from cdpr.simulation.loop_parts import loop_parts
from cdpr.tension.current_sample import Cables, Present
from cdpr.tension.operations import Operation


class Measured(NamedTuple):
    """Column of sensors or estimator that an exported FMU puts out.

    Attributes:
        column: the column.
        values: its numbers, live.
    """

    column: Column
    values: Array


@dataclass(frozen=True, eq=False)
class _Winches:
    """Exported plant, as sensors see a backend: the surrounding code reads its winches."""

    gravity: Array
    paid_out: Array  # (2, m), m and m/s

    def winch_readings(self, unwound: Array, unwinding: Array, torque: Array) -> list[Any]:
        """Return the operations that write the state of the winches."""
        pairs = zip(self.paid_out, (unwound, unwinding), strict=True)
        return [bind("copy", source=source, target=target) for source, target in pairs]


class ExportedSensors:
    """Measurements and estimates that the controller of an exported plant sees.

    Noise, delays and losses have the bits of a run: they depend on the seed and the names of the sensors.

    Args:
        scenario: scenario.
        state: (13,), true state, live.
        live: arrays of the tension stage.
        cables: limits of the tension stage.

    Attributes:
        seen: (13,), state that the controller sees; `state` itself if no part writes it.
        seen_cables: (2, m), lengths, m, and rates, m/s, that it measures.
        sent: (m,), N, tensions as sent in the previous control step; 0 before the first one.
        locked: (m,), False: nothing jams in an exported plant.
        measurements: columns of the sensors by name, live.
        named: arrays that the surrounding code writes, by name.
    """

    def __init__(self, scenario: Scenario, state: Array, live: Present, cables: Cables) -> None:
        m = scenario.robot.m
        self._scenario, self._state, self._live, self._cables = scenario, state, live, cables
        self._parts = loop_parts(scenario)
        self._layout = Layout(m, columns_of(scenario))
        self._row = np.zeros(self._layout.width)
        true_cables, paid_out, pulls = np.zeros((2, m)), np.zeros((2, m)), np.zeros((2, m))
        self.seen = np.zeros(13) if writes(self._parts, "seen") else state
        self.seen_cables = np.zeros((2, m)) if writes(self._parts, "seen_cables") else true_cables
        self.sent, self.locked = np.zeros(m), np.zeros(m, dtype=bool)
        self._true_cables, self._paid_out, self._pulls = true_cables, paid_out, pulls
        self._columns = {
            ("length", "rate"): true_cables.reshape(-1),
            ("length", "length"): true_cables[0],
            ("rate", "rate"): true_cables[1],
            ("tension", "tension"): live.tension,
            ("cable_tension", "cable_tension"): pulls[0],
            ("winch_tension", "winch_tension"): pulls[1],
        }
        self.measurements = {
            column.name: read_only(self._view(column.name))
            for part in self._parts
            if part.measures
            for column in part.columns
        }
        self.named: dict[str, Array] = {}
        self._connected: list[LoopPart] = []
        self._outputs: list[Measured] = []

    def show(self, controller: Controller) -> None:
        """Give a controller the measurements, if it uses them, and its columns."""
        if not observes(controller):
            return
        known, limits, sent = read_only(self.locked), read_only(self._cables.limits), read_only(self.sent)
        controller.observe(ControllerInputs(_no_preview, limits, known, sent, MappingProxyType(self.measurements)))
        own = [column for column in self._layout.more if column.owner == "controller"]
        if own:
            controller.log({column.name: self._view(column.name) for column in own})

    def _view(self, first: str, last: str | None = None) -> Array:
        """Return the columns from the field `first` to `last`, live."""
        last = last or first
        known = self._columns.get((first, last))
        return self._row[self._layout.span(first, last)] if known is None else known

    def calls(self, lines: Array, winch_command: Array | None, later: Sequence[Call]) -> list[Call]:
        """Return the operations before the law of the controller: geometry, measurements, estimate.

        Sensors that neither the controller nor the estimator uses are left out.

        Args:
            lines: lines of the robot, as of `cdpr.cables.tables.line_table`.
            winch_command: (m,), commands of winches that take lengths or rates; None without such winches.
            later: operations after these.
        """
        m, live, separate = self._scenario.robot.m, self._live, self.seen is not self._state
        if winch_command is not None:
            self._columns["winch_command", "winch_command"] = winch_command
        unread = np.zeros((6, m)), np.zeros(m), np.zeros(m)
        matrix, (length, rate) = unread[0] if separate else live.W, self._true_cables
        before = [Call(bind("geometry", lines=lines, state=self._state, matrix=matrix, length=length, rate=rate))]
        pairs = (self._state, self.seen), (self._true_cables.reshape(-1), self.seen_cables.reshape(-1))
        before += [Call(bind("copy", source=truth, target=own)) for truth, own in pairs if not _same(truth, own)]
        after = [Call(bind("not_finite", values=own), FINITE) for truth, own in pairs if not _same(truth, own)]
        if separate:
            about = {"matrix": live.W, "length": unread[1], "rate": unread[2]}
            after.append(Call(bind("geometry", lines=lines, state=self.seen, **about)))
        sent = Call(bind("copy", source=live.tension, target=self.sent))
        stamp = Call(bind("stamp", row=self._view("time")))
        found = _used([stamp, sent, *self._observing()], [*before, *after, *later])
        written = _spans(found, ("out", "both"))
        self._outputs = [
            Measured(column, self._view(column.name))
            for part in self._parts
            for column in part.columns
            if _overlap(_span(self._view(column.name)), written)
        ]
        read = _spans(found, ("in", "both"))
        winches = {PAID_OUT: self._paid_out, PULLS: self._pulls}
        self.named = {name: array for name, array in winches.items() if _overlap(_span(array), read)}
        return [*before, *found, *after]

    def _observing(self) -> list[Call]:
        scenario = self._scenario
        plant = cast("Backend", _Winches(scenario.gravity, self._paid_out))
        calls: list[Call] = []
        for part in self._parts:
            own = {column.name: self._view(column.name) for column in part.columns}
            about = scenario.robot, plant, scenario.simulation.control_step, self._view, self._layout.has, own
            cables = self._cables.held, self.sent, self._cables.limits, self.locked
            part.connect(Surroundings(*about, self._state, self.seen, self.seen_cables.reshape(2, -1), *cables))
            self._connected.append(part)
            calls += [_call(part, each) for each in part.observed(scenario.simulation.control_step)]
        return calls

    @property
    def outputs(self) -> Sequence[Measured]:
        """Measured and estimated values, after `calls`."""
        return self._outputs

    @property
    def unused(self) -> list[str]:
        """Names of the sensors that are left out, after `calls`."""
        known = {each.column.name for each in self._outputs}
        sensors = measuring(self._scenario.sections.sensors)
        return [each.title for each in sensors if f"{each.title}_age" not in known]

    def close(self) -> None:
        """Close the estimator; may be called again."""
        while self._connected:
            self._connected.pop().close()


def _no_preview(times: ArrayLike) -> Array:
    raise CdprError(
        "the controller uses a preview of the desired motion, which an exported FMU does not have: choose another "
        "(--set controller.type=NAME)"
    )


def _call(part: LoopPart, operation: Operation) -> Call:
    if not hasattr(operation.do, "given"):
        raise CdprError(
            f"the {operation.name} has no operation in the kernel library, so an exported FMU cannot contain it: "
            f"choose another (--set {part.section or part.name}.type=NAME)"
        )
    return Call(operation.do, IGNORED if operation.refused is None else ESTIMATE)


def _same(one: Array, other: Array) -> bool:
    return address(one) == address(other)


def _used(calls: Sequence[Call], later: Sequence[Call]) -> list[Call]:
    """Return those of the calls that write what others, or itself used calls, read in this or the next control step."""
    used: set[int] = set()
    read = _spans(later, ("in", "both"))
    while True:
        more = {
            i for i, call in enumerate(calls) if i not in used and any(_overlap(each, read) for each in _written(call))
        }
        if not more:
            return [calls[i] for i in sorted(used)]
        used |= more
        read += _spans([calls[i] for i in more], ("in", "both"))


def _written(call: Call) -> list[tuple[int, int]]:
    return _spans([call], ("out", "both"))


def _spans(calls: Iterable[Call], roles: Sequence[str]) -> list[tuple[int, int]]:
    """Return the first and last address of the arrays with these roles."""
    return [_span(array) for call in calls for role, array in members(call) if array is not None and role in roles]


def _span(array: Array) -> tuple[int, int]:
    return address(array), address(array) + array.nbytes


def _overlap(span: tuple[int, int], others: Iterable[tuple[int, int]]) -> bool:
    return any(span[0] < end and begin < span[1] for begin, end in others)
