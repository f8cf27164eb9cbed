"""Batch of closed loops of one scenario, stepped by the caller."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from threading import Lock
from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cdpr.analysis.rollouts.case import BLOCK, Case, Given, Plan
from cdpr.analysis.rollouts.commands import check_given, given_command, rows_of
from cdpr.analysis.rollouts.group import Group
from cdpr.analysis.rollouts.vary import check_count, check_seed, values_of
from cdpr.base import tolerances
from cdpr.base.errors import CdprError, PluginError
from cdpr.base.nearest import did_you_mean
from cdpr.base.problems import shown
from cdpr.model.robot import Array, read_only
from cdpr.native.arrays import MASKED, masked
from cdpr.native.operations import LANES
from cdpr.plugins import Backend, Controller, Estimator, TensionSolver
from cdpr.scenario import Scenario
from cdpr.scenario.events.commands import Kind
from cdpr.scenario.loader import AnyScenario
from cdpr.scenario.repeatable import check_repeatable
from cdpr.simulation.branches import Snapshot
from cdpr.simulation.live import ExclusiveAccess
from cdpr.simulation.moment import Moment
from cdpr.simulation.needs import require
from cdpr.simulation.start import Chosen, chosen_scenario


class Batch:
    """Closed loops of one scenario, one per lane, stepped together.

    On `reference`, each lane has the bits of its own `Simulation`. Lanes have their own time, events and end: a lane
    that fails stops alone, with its message. Between two calls a row holds the state and the desired motion of the
    present time, and the decisions of the last complete sample, as in a `Simulation`.

    Args:
        scenario: a Scenario, a file, the name of an example, or a dict with the keys of a scenario file.
        lanes: number of lanes.
        vary: values by dotted key, one for each lane, as for `rollout`; by default all lanes are equal.
        seed: seed of the distributions in `vary`.
        overrides: values by dotted key, in all lanes.
        backend: backend by name or class, as for `simulate`.
        solver: tension solver, likewise.
        controller: controller, likewise.
        estimator: estimator, likewise.

    Attributes:
        rows: (columns, lanes) rows of all lanes, columns as in `Run.rows`; live and read-only.
        time: (lanes,) s, present time of each lane; live and read-only.
        samples: (lanes,) number of complete samples of each lane; live and read-only.
        active: (lanes,) lanes that can be stepped; live and read-only.

    Raises:
        ScenarioError: if the scenario is wrong, or no lane accepts its values.
        PluginError: if a plugin is missing or broken.

    Example:
        >>> import cdpr
        >>> batch = cdpr.Batch("caroca", 16, vary={"controller.kp": {"uniform": [80.0, 200.0]}})
        >>> batch.step(100)
        >>> batch.column("position").shape, float(batch.time[0]), bool(batch.active.all())
        ((3, 16), 0.1, True)
        >>> batch.reset(3)
        >>> batch.step(5, mask=batch.time < 0.05)
        >>> batch.time[2:4]
        array([0.1  , 0.005])
    """

    def __init__(
        self,
        scenario: AnyScenario,
        lanes: int,
        *,
        vary: Mapping[str, Any] | None = None,
        seed: int = 0,
        overrides: Mapping[str, Any] | None = None,
        backend: str | type[Backend] | None = None,
        solver: str | type[TensionSolver] | None = None,
        controller: str | type[Controller] | None = None,
        estimator: str | type[Estimator] | None = None,
    ) -> None:
        n = check_count(lanes, "Batch: lanes")
        chosen: Chosen = {"backend": backend, "solver": solver, "controller": controller, "estimator": estimator}
        check_seed(seed, "Batch")
        values = {} if vary is None else values_of(vary, n, seed, overrides, chosen, "Batch")
        base = chosen_scenario(scenario, chosen, overrides)
        check_repeatable(base, "a batch")
        require(base, "rollout")
        self._plan = plan = Plan(base, tuple(values), 0, ())
        self._at_work, self._closed = Lock(), False
        self._rows = np.full((plan.layout.width, n), np.nan)
        self._time, self._samples = np.zeros(n), np.zeros(n, dtype=np.int64)
        self._active = np.zeros(n, dtype=bool)
        self.rows, self.time = read_only(self._rows), read_only(self._time)
        self.samples, self.active = self._samples.view(), self._active.view()
        self.samples.flags.writeable = self.active.flags.writeable = False
        ring, none = np.empty((min(plan.steps + 1, BLOCK), plan.layout.width)), np.empty((0, 0))
        self._cases = [
            Case(plan, i, [each[i] for each in values.values()], ring, none, lambda: False) for i in range(n)
        ]
        self._starts: list[Moment | None] = [None] * n
        self._groups = [Group(plan) for _ in range(0, n, LANES)]
        try:
            for lane in range(n):
                self._begin(lane)
            if not self._active.any():
                raise self._cases[0].error or CdprError(f"Batch: no lane began: {self.errors[0]}")
        except BaseException:
            self.close()
            raise

    def __repr__(self) -> str:
        ended = len(self._cases) - int(self._active.sum())
        return f"<Batch of {len(self._cases)} lanes of {self.scenario.name}{f', {ended} ended' if ended else ''}>"

    def __len__(self) -> int:
        """Return the number of lanes."""
        return len(self._cases)

    @property
    def scenario(self) -> Scenario:
        """Return the scenario without the varied values."""
        return self._plan.scenario

    @property
    def errors(self) -> tuple[str, ...]:
        """Return the message of each lane that ended early; "" for the others."""
        return tuple(case.outcome.message for case in self._cases)

    def column(self, name: str) -> Array:
        """Return the column of a name, (components, lanes); live and read-only.

        Raises:
            CdprError: No column has that name.
        """
        known = self._plan.layout.columns
        if not isinstance(name, str) or name not in known:
            hint = did_you_mean(name, list(known)) if isinstance(name, str) else ""
            raise CdprError(f"column: unknown column {shown(name)}: {hint}allowed: {', '.join(known)}")
        at = known[name]
        return self.rows[at if isinstance(at, slice) else slice(at, at + 1)]

    def step(
        self,
        n: int = 1,
        *,
        mask: ArrayLike | None = None,
        wrench: ArrayLike | None = None,
        tension: ArrayLike | None = None,
        length: ArrayLike | None = None,
        rate: ArrayLike | None = None,
        command: ArrayLike | None = None,
    ) -> None:
        """Take active lanes n control steps further, or as many as they have left.

        With its last step a lane completes the last sample, and becomes inactive. Wrenches and commands are held for
        the n steps, with the meaning and the bits of those of `Simulation.step`; rows of lanes that are not stepped are
        ignored.

        Args:
            n: number of steps, at least 1.
            mask: (lanes,) True for the lanes to step; by default all.
            wrench: (lanes, 6) required wrenches of the cables, N and N m, in place of the controllers' answers.
            tension: (lanes, m) tensions, N, in place of the solver's answers, too.
            length: (lanes, m) unwound lengths, m, likewise; all winches must take lengths.
            rate: (lanes, m) rates of the unwound lengths, m/s, likewise.
            command: (lanes, m) for each cable the quantity that its winch takes: N, m or m/s.

        Raises:
            CdprError: if an argument is wrong, or the batch is closed. Errors that end a lane are in `errors`.
        """
        if isinstance(n, bool) or not isinstance(n, int | np.integer) or n < 1:
            raise CdprError(f"step: expected a whole number of steps, at least 1, got {shown(n)}")
        with self._exclusive("step"):
            self._open("step")
            kinds: dict[Kind, ArrayLike | None] = {"wrench": wrench, "tension": tension, "length": length}
            kinds |= {"rate": rate, "command": command}
            chosen = self._active if mask is None else self._active & self._mask(mask)
            given = given_command(kinds, chosen, self.scenario.robot.m)
            bits = chosen.tolist()
            if given is not None:
                check_given(self._cases, np.flatnonzero(chosen).tolist(), given, int(n), self._plan.steps)
            for first in range(0, len(self), LANES):
                stop = min(first + LANES, len(self))
                lanes = [lane for lane in range(first, stop) if bits[lane]]
                if lanes:
                    at = slice(first, stop) if len(lanes) == stop - first else lanes
                    self._go(lanes, at, int(n), rows_of(given, at))

    def reset(self, lanes: int | Sequence[int] | NDArray[np.integer] | None = None) -> None:
        """Restart lanes, also those that have ended.

        Args:
            lanes: number of a lane, or several; by default all.

        Raises:
            CdprError: if there is no such lane, or the batch is closed.
        """
        with self._exclusive("reset"):
            self._open("reset")
            chosen: Sequence[Any] = (
                range(len(self)) if lanes is None else np.atleast_1d(_as_array("reset", lanes)).tolist()
            )
            for lane in [self._lane("reset", lane) for lane in chosen]:
                start = self._starts[lane]
                if start is None:
                    self._cases[lane].close()
                    self._cases[lane] = self._cases[lane].again()
                    self._begin(lane)
                else:
                    self._cases[lane].restore(start)
                    self._show([lane])

    def load(self, lane: int, snapshot: Snapshot) -> None:
        """Load a state into a lane, also one that has ended; it continues from there with its own events and values.

        Live events of a simulation up to then, such as `Simulation.push`, belong to its state: they continue in the
        lane until another state is loaded or the lane is reset.

        Args:
            lane: number of the lane.
            snapshot: result of `Simulation.snapshot` for a simulation of this structure, or of `snapshot` of a batch.

        Raises:
            CdprError: if there is no such lane, it never began, or the snapshot does not fit.
            PluginError: if a plugin does not support snapshots.
        """
        with self._exclusive("load"):
            case = self._started_case("load", lane)
            if not isinstance(snapshot, Snapshot):
                raise CdprError(f"load: expected a snapshot of a simulation or a batch, got {shown(snapshot)}")
            moment = snapshot.moment
            case.leave_block()
            if not _alike(moment, case.loop.snapshot()):
                raise CdprError("load: the snapshot is of another robot, backend, controller or solver than the lane")
            step = self.scenario.simulation.control_step
            if not math.isclose(moment.time, moment.count * step, rel_tol=tolerances.TIME):
                raise CdprError(f"load: the snapshot is of another control step than that of the lane, {step:g} s")
            if moment.count > self._plan.steps + 1:
                end = self._plan.steps * step
                raise CdprError(f"load: the snapshot is of t = {moment.time:g} s, after the end of the lane, {end:g} s")
            case.restore(moment, snapshot.done[0])
            self._show([lane])

    def snapshot(self, lane: int) -> Snapshot:
        """Return the state of a lane for `load`.

        Raises:
            CdprError: if there is no such lane, or it never began.
            PluginError: if a plugin does not support snapshots.
        """
        with self._exclusive("snapshot"):
            case = self._started_case("snapshot", lane)
            case.leave_block()
            return Snapshot(case.loop.snapshot(), (case.live, None))

    def close(self) -> None:
        """Free the memory of the lanes; may be called again."""
        with self._exclusive("close"):
            for case in self._cases:
                case.close()
            self._active[:] = False
            self._closed = True

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _exclusive(self, what: str) -> ExclusiveAccess:
        return ExclusiveAccess(self._at_work, what)

    def _open(self, what: str) -> None:
        """Raise CdprError if the batch is closed."""
        if self._closed:
            raise CdprError(f"{what}: the batch is closed")

    def _begin(self, lane: int) -> None:
        case = self._cases[lane]
        self._rows[:, lane] = np.nan
        self._time[lane] = self._samples[lane] = self._active[lane] = 0
        case.begin()
        if case.going:
            with suppress(PluginError):
                self._starts[lane] = case.loop.snapshot()
        if case.started:
            self._show([lane])

    def _go(self, lanes: list[int], at: slice | list[int], n: int, given: Given | None) -> None:
        """Step lanes of one group; `at` are the same lanes as an index."""
        cases, last = [self._cases[lane] for lane in lanes], self._plan.steps
        group, samples = self._groups[lanes[0] // LANES], self._samples[at] + n
        stops = [min(case.count + n, last) for case in cases]
        if samples.max() < last and group.again(cases, stops, given, self._rows, at):
            self._samples[at], self._time[at] = samples, self._rows[0, at]
            return
        group.go(cases, stops, given)
        for case in cases:
            if case.count == last and case.going:
                case.finish()
        self._show(lanes)

    def _show(self, lanes: Sequence[int]) -> None:
        """Update the rows of begun lanes of one group."""
        cases, last, rows = [self._cases[lane] for lane in lanes], self._plan.steps, self._rows
        self._groups[lanes[0] // LANES].show(cases, rows, lanes)
        for lane, case in zip(lanes, cases, strict=True):
            if case.home is None:
                rows[:, lane] = case.loop.row
        self._time[lanes] = [case.time for case in cases]
        self._samples[lanes] = [case.count for case in cases]
        self._active[lanes] = [case.going and case.count <= last for case in cases]

    def _lane(self, what: str, lane: object) -> int:
        n = len(self)
        if isinstance(lane, bool) or not isinstance(lane, int | np.integer) or not 0 <= lane < n:
            raise CdprError(f"{what}: expected the number of a lane, 0 to {n - 1}, got {shown(lane)}")
        return int(lane)

    def _started_case(self, what: str, lane: object) -> Case:
        case = self._cases[self._lane(what, lane)]
        if not case.started:
            raise CdprError(f"{what}: lane {lane} did not start: {case.outcome.message or 'the batch is closed'}")
        return case

    def _mask(self, mask: ArrayLike) -> NDArray[np.bool_]:
        found = _as_array("step: mask", mask)
        if found.dtype != bool or found.shape != (len(self),):
            raise CdprError(f"step: mask: expected ({len(self)},) of bool, got {found.shape} of {found.dtype}")
        return found


def _as_array(what: str, values: Any) -> NDArray[Any]:
    if masked(values):
        raise CdprError(f"{what}: {MASKED}")
    try:
        return np.asarray(values)
    except ValueError as error:
        raise CdprError(f"{what}: {error}") from error


def _alike(one: object, other: object) -> bool:
    """Return whether two snapshots consist of arrays of the same types and shapes."""
    arrays, others = list(_arrays(one)), list(_arrays(other))
    return [(a.shape, a.dtype) for a in arrays] == [(a.shape, a.dtype) for a in others]


def _arrays(part: object) -> Iterator[NDArray[Any]]:
    if isinstance(part, np.ndarray):
        yield part
    elif isinstance(part, list | tuple):
        for each in part:
            yield from _arrays(each)
    elif isinstance(part, Moment) or type(part).__module__.startswith("cdpr."):
        yield from _arrays(list(vars(part).values()))
