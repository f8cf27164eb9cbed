"""Simulation that is advanced step by step."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from numbers import Real
from threading import Lock
from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from cdpr.base import tolerances
from cdpr.base.errors import CdprError, PlantEnded, one_line
from cdpr.base.lazy import late
from cdpr.base.problems import shown
from cdpr.log.header import Header
from cdpr.log.run import Run
from cdpr.log.run_folder import RunFolder
from cdpr.model.arrays import checked
from cdpr.model.robot import Array, read_only
from cdpr.plugins import Backend, Controller, Estimator, TensionSolver
from cdpr.scenario import Scenario
from cdpr.scenario.events import ScenarioEvent, first_sample
from cdpr.scenario.events.commands import Kind
from cdpr.scenario.loader import AnyScenario
from cdpr.simulation.branches import Branches
from cdpr.simulation.header import make_header
from cdpr.simulation.live import ExclusiveAccess
from cdpr.simulation.pace import Pace
from cdpr.simulation.pipeline import Pipeline
from cdpr.simulation.runner import Runner
from cdpr.simulation.start import Chosen, attempt

Observer = Callable[[Array], None]


class Simulation(Branches):
    """Closed loop that is stepped by its user; `simulate` runs one to its end.

    Args:
        scenario: a Scenario, a file, the name of an example, or a dict with the keys of a scenario file.
        backend: name or class of the backend that replaces the scenario's; a class need not be installed, and may hold
            `Options`, the model of its options, and `properties`.
        solver: tension solver, likewise.
        controller: controller, likewise.
        estimator: estimator, likewise.
        overrides: values by dotted key, such as {"simulation.duration": 2.0}, checked like the file.
        out: folder, new or empty, for log, resolved scenario and run.json; by default nothing is written.

    Between two calls, state and desired motion are those of the present time. The next step decides the commands of the
    cables and takes the plant to the next sample. A `with` statement closes the simulation at its end. Errors that end
    it early (Infeasible, Diverged, ...) have all samples in their attribute `run`, as those of `simulate`. The
    constructor raises the same errors as `simulate`.

    Example:
        >>> import cdpr
        >>> with cdpr.Simulation("caroca") as simulation:
        ...     simulation.step(100)
        ...     before = simulation.snapshot()
        ...     simulation.step(50, wrench=[0.0, 0.0, 1500.0, 0.0, 0.0, 0.0])
        ...     simulation.restore(before)
        ...     print(simulation.time, simulation.state.shape)
        0.1 (13,)
    """

    def __init__(
        self,
        scenario: AnyScenario,
        *,
        backend: str | type[Backend] | None = None,
        solver: str | type[TensionSolver] | None = None,
        controller: str | type[Controller] | None = None,
        estimator: str | type[Estimator] | None = None,
        overrides: Mapping[str, Any] | None = None,
        out: str | os.PathLike[str] | RunFolder | None = None,
    ) -> None:
        self._observers: list[Observer] = []
        self._at_work = Lock()
        self._stepping = self._exclusive("step")
        chosen: Chosen = {"backend": backend, "solver": solver, "controller": controller, "estimator": estimator}
        self._start(attempt(scenario, chosen, overrides, out))

    def _start(self, runner: Runner) -> None:
        """Build, and observe sample 0."""
        self._runner, self._origin = runner, object()
        with self._kept():
            loop, self._recorder = runner.begin()
            self._pace = Pace(self._recorder.flush)
            self._loop, self._last = loop, runner.scenario.simulation.steps
            with loop.timed():
                loop.begin(self._recorder.rows, self._last)
        self._row = read_only(self._loop.row)

    def __repr__(self) -> str:
        simulation = self.scenario.simulation
        state = ", done" if self.done else ""
        whole = self.steps * simulation.control_step
        return f"<Simulation of {self.scenario.name} on {simulation.backend}: {self.time:.6g} of {whole:.6g} s{state}>"

    def _repr_html_(self) -> str:
        """Return the display of a notebook."""
        html: str = late("Simulation._repr_html_")(self)
        return html

    @property
    def scenario(self) -> Scenario:
        """Return the scenario."""
        return self._runner.scenario

    @property
    def steps(self) -> int:
        """Return the number of control steps."""
        return self.scenario.simulation.steps

    @property
    def samples(self) -> int:
        """Return the number of complete samples."""
        return self._loop.count

    @property
    def time(self) -> float:
        """Return the present time, s."""
        return self._loop.time

    @property
    def done(self) -> bool:
        """Return True if no step is left."""
        return self._runner.run is not None or self._loop.count > self._last

    @property
    def steps_before_stop(self) -> float:
        """Return the number of steps in which `step` takes `wrench` and `tension`; infinity without a stop."""
        return self._loop.outside.steps_left(self._loop.count, self._last)

    @property
    def row(self) -> Array:
        """Return a copy of the last complete sample, columns as in `Run.rows`.

        Raises:
            CdprError: before the first step.
        """
        if not self._loop.count:
            raise CdprError("row: no sample is complete before the first step")
        rows = self._recorder.rows
        return np.array(rows[(self._loop.count - 1) % len(rows)])

    def rows(self, first: int = 0) -> Array:
        """Return a copy of the complete samples from number `first` on, (n, width), columns as in `Run.rows`.

        A thinned simulation, or one with a log too long for memory, provides the last 4096; after a restore of a
        thinned one, these are the last sample before it and those since.
        """
        rows, stop = self._recorder.rows, self._loop.count
        start = max(first, stop - len(rows), self._recorder.first)
        return np.array(rows[np.arange(start, max(start, stop)) % len(rows)])

    @property
    def events(self) -> tuple[ScenarioEvent, ...]:
        """Return the events of the scenario and the live ones, in the order of their definition."""
        return self._runner.session.events

    @property
    def header(self) -> Header:
        """Return the header of the run's log, with the events so far."""
        return self._runner.header

    @property
    def state(self) -> Array:
        """Return a copy of the state of the platform, (13,), in the layout of `cdpr.model`."""
        return self._loop.state.copy()

    @property
    def desired(self) -> Array:
        """Return a copy of the desired state and accelerations, (19,), likewise."""
        return self._loop.desired.copy()

    @property
    def tension(self) -> Array:
        """Return a copy of the commanded tensions in the last complete sample, (m,), N; zeros before the first step."""
        return self._loop.tension.copy()

    def step(
        self,
        n: int = 1,
        *,
        wrench: ArrayLike | None = None,
        tension: ArrayLike | None = None,
        length: ArrayLike | None = None,
        rate: ArrayLike | None = None,
        command: ArrayLike | None = None,
    ) -> None:
        """Take n control steps, or as many as are left; the last one also completes the last sample.

        Args:
            n: number of steps, at least 1.
            wrench: (6,) required wrench of the cables during these steps, N and N m; it replaces the controller's
                answer and is distributed likewise. The controller is not called. Not possible from a stop on.
            tension: (m,) tensions, N, clipped to the limits; they replace the solver's answer, too.
            length: (m,) unwound lengths, m, in place of tensions; all winches must take lengths.
            rate: (m,) rates of the unwound lengths, m/s, likewise.
            command: (m,) for each cable the quantity that its winch takes: N, m or m/s.

        Raises:
            CdprError: if an argument or the call is wrong.
            SimulationStopped: if the run ends early.
            PluginError: if a plugin fails.
        """
        if type(n) is not int or n < 1:
            n = _steps(n)
        with self._stepping:
            first, last = self._loop.pipeline.count, self._last
            if first > last or self._runner.run is not None:
                self._ready()
            until = first + n
            if until > last:
                until, n = last, last - first
            given, outside = None, self._loop.outside
            found: tuple[Kind, ArrayLike] | None = None
            if wrench is not None:
                found = "wrench", wrench
            if tension is not None:
                found = _only(found, "tension", tension)
            if length is not None:
                found = _only(found, "length", length)
            if rate is not None:
                found = _only(found, "rate", rate)
            if command is not None:
                found = _only(found, "command", command)
            if found is not None:
                if outside.end <= last:
                    outside.check_stop(first, n, last)
                given = outside.give(*found, n)
            self._go(until, given)

    def until(self, time: float) -> None:
        """Continue to the first sample at or after `time` (s), or to the end."""
        with self._exclusive("until"):
            self._until(time)

    def _until(self, time: float) -> None:
        self._ready()
        known = isinstance(time, Real) and not isinstance(time, bool) and np.isfinite(float(time))
        if not known or time < self.time * (1.0 - tolerances.TIME):
            raise CdprError(f"until: expected at least the current time, {self.time:g} s, got {shown(time)}")
        period = self.scenario.simulation.control_step
        last = min(first_sample(time, period), self._last)
        self._go(last, None)

    def observe(self, observer: Observer) -> None:
        """Call `observer(row)` with each complete sample from now on.

        The row is read-only and live: copy values to keep them. An exception of an observer ends the run as failed.
        """
        if not callable(observer):
            raise CdprError(f"observe: expected a function of a row, got {shown(observer)}")
        self._observers.append(observer)

    def reset(self, state: ArrayLike | None = None, *, seed: int | None = None) -> None:
        """Restart the simulation, also after its end; computed samples are discarded, observers stay.

        Args:
            state: (13,) initial state in the layout of `cdpr.model`, in place of the scenario's. It is checked
                likewise, and a motion that begins at the initial pose begins here.
            seed: seed in place of the scenario's.

        Raises:
            CdprError: if there is a log, whose samples stay: create another simulation.
        """
        with self._exclusive("reset"):
            self._reset(state, seed)

    def _reset(self, state: ArrayLike | None, seed: int | None) -> None:
        if self._runner.folder is not None:
            raise CdprError("reset: not possible with a log on disk; create another simulation, or omit `out`")
        changes: dict[str, Any] = {} if seed is None else {"simulation.seed": seed}
        if state is not None:
            x = checked(state, (13,), "state", finite=True).tolist()
            rates = {"velocity": x[7:10], "angular_velocity": x[10:]}
            changes["initial"] = {"position": x[:3], "orientation": {"quaternion": x[3:7]}, **rates}
        scenario = self.scenario.with_changes(changes)
        self._end()
        self._start(Runner(scenario, make_header(scenario), None))

    def run(self) -> Run:
        """End the simulation at its present sample and return its run; repeated calls return the same run.

        The status of an incomplete run is "ended".
        """
        if self._runner.run is not None:
            return self._runner.run
        with self._exclusive("run"):
            return self._end()

    def _end(self) -> Run:
        if self._runner.run is not None:
            return self._runner.run
        if self.done:
            return self._runner.end(None)
        stop = PlantEnded(f"t = {self.time:.6g} s: taken no further")
        try:
            return self._runner.end(stop)
        except PlantEnded as ended:
            if ended is not stop or self._runner.run is None:
                raise
            return self._runner.run

    def so_far(self) -> Run:
        """Return the run up to the last complete sample and continue; the status of an incomplete run is "ended"."""
        with self._exclusive("so_far"):
            return self._runner.so_far()

    def close(self) -> None:
        """End the simulation and close the backend; may be called again."""
        self.run()

    def __reduce_ex__(self, protocol: Any) -> Any:
        """Reject copies and pickling: a plant supports neither."""
        raise CdprError(
            "a simulation cannot be copied or pickled: use a snapshot, or create another simulation from its scenario"
        )

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._runner.run is None and isinstance(error, KeyboardInterrupt):
            self._runner.end(error)  # raises it, with the run
        self.close()

    def _ready(self, *, also_done: bool = False) -> None:
        """Reject a call after the end."""
        if self._runner.run is not None:
            raise CdprError(f"the simulation is over: its run is {self._runner.run.status}; make another")
        if self.done and not also_done:
            raise CdprError(f"the simulation is done: the scenario ends at {self.time:g} s; run() returns the run")

    def _exclusive(self, what: str) -> ExclusiveAccess:
        """Reject a call during another one."""
        return ExclusiveAccess(self._at_work, what)

    def _go(self, k: int, given: Pipeline | None) -> None:
        """Continue to sample k; complete it if it is the last. End the run with any error."""
        try:
            if not self._observers:
                self._loop.go(k, self._pace, given)
            if self._observers or k == self._last:
                self._go_watched(k, given)
        except BaseException as error:
            self._runner.end(self._runner.as_cdpr_error(error))

    def _go_watched(self, k: int, given: Pipeline | None) -> None:
        """Do the same with observers or commands."""
        loop, pace = self._loop, self._pace
        with loop.timed():
            while loop.count < k:
                self._decide(given)
                loop.advance()
                pace.after(loop.count)
            if k == self._last:
                self._decide(given)

    def _decide(self, given: Pipeline | None) -> None:
        """Complete a sample."""
        self._loop.decide(given)
        try:
            for observer in self._observers:
                observer(self._row)
        except KeyboardInterrupt:
            raise
        except BaseException as error:
            raise CdprError(f"t = {self.time:.6g} s: an observer raised {one_line(error)}") from error

    @contextmanager
    def _kept(self) -> Iterator[None]:
        """End the run with any exception of the block."""
        try:
            yield
        except BaseException as error:
            self._runner.end(self._runner.as_cdpr_error(error))


def _steps(n: object) -> int:
    """Return a number of steps, at least 1, as an int."""
    if isinstance(n, bool) or not isinstance(n, int | np.integer) or n < 1:
        raise CdprError(f"step: expected a whole number of steps, at least 1, got {shown(n)}")
    return int(n)


def _only(found: tuple[Kind, ArrayLike] | None, kind: Kind, values: ArrayLike) -> tuple[Kind, ArrayLike]:
    """Return a command if it is the only one."""
    if found is not None:
        raise CdprError(f"step: expected {found[0]} or {kind}, not both")
    return kind, values
