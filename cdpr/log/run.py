"""Run in memory: documented arrays and its header."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Self, overload

import numpy as np
from numpy.typing import NDArray

from cdpr.base.columns import known_columns
from cdpr.base.errors import CdprError
from cdpr.base.lazy import late
from cdpr.base.problems import printable, shown
from cdpr.log.event import Event
from cdpr.log.header import Header
from cdpr.log.layout import Rows
from cdpr.model import rotations
from cdpr.model.frozen import Frozen
from cdpr.model.robot import Array, read_only

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.figure import Figure
    from pandas import DataFrame


# Ends that the scenario foresees; such runs are complete results.
FORESEEN = ("finished", "infeasible", "unanswered", "beyond_limits", "touched")

# Smallest clearance in the summary: value, time and pair.
CLEARANCE = ("clearance_min_m", "clearance_min_at_s", "clearance_min_by")


_KNOWN = known_columns()


class Quantity(property):
    """Documented column of a run; AttributeError if the run lacks it, such as those of a nominal model."""

    def __init__(self, name: str) -> None:
        column, condition = _KNOWN[name]

        def read(run: Run) -> Array:
            if name not in run.header.layout.fields:
                raise AttributeError(f"{name}: recorded only if {condition}")
            return run[name]

        super().__init__(read)
        self.__doc__ = column.sentence

    if TYPE_CHECKING:

        @overload
        def __get__(self, run: None, kind: type, /) -> Self: ...
        @overload
        def __get__(self, run: object, kind: type | None = None, /) -> Array: ...
        def __get__(self, run: object, kind: type | None = None, /) -> Self | Array: ...


@dataclass(frozen=True, eq=False)
class Run(Frozen):
    """One run, K rows of a robot with m cables; row k was sampled at time k * control_step.

    If the scenario's `log.step` thins the log, row k was sampled at k * log_step and the last one at the end of the
    run; `summary` and `events` still count every sample. Frames and signs are those of `cdpr.model`. Arrays are
    read-only; copy them to change them.

    Values of `status`: "finished"; "ended" (requested by the plant); "diverged"; "infeasible" (no admissible tensions,
    if the scenario stops then); "unanswered" (likewise, no valid answer of the solver); "beyond_limits" (likewise,
    limit violation of a length, speed or commanded tension); "touched" (likewise, too small a clearance);
    "interrupted"; "failed"; "running" (killed while it ran). Logs of earlier versions have "infeasible" instead of
    "unanswered" and "beyond_limits".

    Example:
        >>> import cdpr
        >>> run = cdpr.simulate("caroca", overrides={"simulation.duration": 0.1})
        >>> run.position.shape, run["residual"].shape
        ((101, 3), (101,))
        >>> run.summary()["status"]
        'finished'
    """

    header: Header
    rows: Array | Rows  # (K, width), columns as in header.layout; for long runs, read from the log on access
    status: str = "finished"
    message: str = ""
    events: tuple[Event, ...] = ()
    timings: dict[str, float] = field(default_factory=dict)  # s of wall time; empty if unknown
    unused: tuple[str, ...] = ()  # keys of the scenario that the run did not use
    interpreted: tuple[str, ...] | None = None  # parts of its steps executed by Python; if empty, all compiled
    plugins: dict[str, Any] = field(default_factory=dict)  # by role, data reported by a plugin for this run
    folder: str | None = None
    counted: dict[str, Any] | None = field(default=None, repr=False)  # figures of all samples, if the rows are thinned
    clearance: dict[str, Any] = field(default_factory=dict)  # smallest clearance, time and pair, if known
    start: Array | None = field(default=None, repr=False)  # first row of the run of which this is a part

    time = Quantity("time")
    position = Quantity("position")
    orientation = Quantity("orientation")
    velocity = Quantity("velocity")
    angular_velocity = Quantity("angular_velocity")
    desired_position = Quantity("desired_position")
    desired_orientation = Quantity("desired_orientation")
    desired_velocity = Quantity("desired_velocity")
    desired_angular_velocity = Quantity("desired_angular_velocity")
    desired_acceleration = Quantity("desired_acceleration")
    desired_angular_acceleration = Quantity("desired_angular_acceleration")
    wrench = Quantity("wrench")
    tension = Quantity("tension")
    length = Quantity("length")
    rate = Quantity("rate")
    solver_status = Quantity("status")  # status of the solver's answer, not of the run
    residual = Quantity("residual")
    margin = Quantity("margin")
    at_limit = Quantity("at_limit")
    external = Quantity("external")
    kinetic = Quantity("kinetic")
    potential = Quantity("potential")
    cable_work = Quantity("cable_work")
    external_work = Quantity("external_work")
    load_energy = Quantity("load_energy")
    true_wrench = Quantity("true_wrench")
    true_margin = Quantity("true_margin")
    winch_tension = Quantity("winch_tension")
    winch_command = Quantity("winch_command")
    unstretched_length = Quantity("unstretched_length")
    unstretched_rate = Quantity("unstretched_rate")
    drum_angle = Quantity("drum_angle")
    drum_speed = Quantity("drum_speed")
    motor_torque = Quantity("motor_torque")
    motor_power = Quantity("motor_power")
    motor_current = Quantity("motor_current")
    motor_voltage = Quantity("motor_voltage")
    electrical_power = Quantity("electrical_power")
    counted_length = Quantity("counted_length")
    lost_steps = Quantity("lost_steps")
    bending_wrench = Quantity("bending_wrench")
    drive_command = Quantity("drive_command")
    estimated_position = Quantity("estimated_position")
    estimated_orientation = Quantity("estimated_orientation")
    estimated_velocity = Quantity("estimated_velocity")
    estimated_angular_velocity = Quantity("estimated_angular_velocity")
    estimate_sigma = Quantity("estimate_sigma")
    nees = Quantity("nees")
    nis = Quantity("nis")
    nis_size = Quantity("nis_size")

    def __post_init__(self) -> None:
        """Make the rows read-only."""
        if isinstance(self.rows, np.ndarray):
            object.__setattr__(self, "rows", read_only(self.rows))

    def __repr__(self) -> str:
        header = self.header
        return printable(f"<Run of {header.scenario} on {header.backend}: {len(self.rows)} samples, {self.status}>")

    def part(self, first: int, stop: int) -> Run:
        """Return rows `first` to `stop` (excluded); energies still count from the first row of the whole run."""
        start = self.start if self.start is not None or not len(self.rows) else self.rows[0]
        return Run(self.header, self.rows[first:stop], self.status, start=start)

    def picked(self, rows: NDArray[np.int64]) -> Run:
        """Return the rows with these indices (n,); quantities that require neighbouring rows are invalid."""
        start = self.start if self.start is not None or not len(self.rows) else self.rows[0]
        return Run(self.header, self.rows[rows], self.status, start=start)

    @property
    def span(self) -> tuple[float, float]:
        """Times of the first and the last row, s; zeros if there is none."""
        return (float(self.rows[0][0]), float(self.rows[-1][0])) if len(self.rows) else (0.0, 0.0)

    def __getitem__(self, name: str) -> Array:
        """Return a field by name: (K,) if it has one column, else (K, columns)."""
        layout = self.header.layout
        if name not in layout.fields:
            raise KeyError(f"unknown field {shown(name)}; allowed: {', '.join(layout.fields)}")
        block = self.rows[:, layout.columns[name]]
        block.flags.writeable = False
        return block[:, 0] if layout.fields[name].width == 1 else block

    @property
    def acceleration(self) -> Array:
        """Mean acceleration of the origin over the period after each sample, (K, 3), m/s^2, world; last row NaN."""
        return self._quotient(self.velocity)

    @property
    def angular_acceleration(self) -> Array:
        """Mean angular acceleration over the period after each sample, (K, 3), rad/s^2, world; last row NaN."""
        return self._quotient(self.angular_velocity)

    @property
    def position_error(self) -> Array:
        """Desired minus actual position, (K, 3), m, world."""
        return self.desired_position - self.position

    @property
    def orientation_error(self) -> Array:
        """Rotation vector from the actual to the desired attitude, (K, 3), rad, world."""
        return rotations.between(self.orientation, self.desired_orientation)

    def tool(self, name: str) -> Array:
        """Return the position of a tool, (K, 3), m, world.

        Raises:
            CdprError: if there is no such tool.
        """
        tools = self.header.tools
        if name not in tools:
            known = f"one of {', '.join(tools)}" if tools else "none: name tools in robot.platform.tools; one"
            raise CdprError(f"tool: expected {known}, got {shown(name)}")
        return np.asarray(self.position + rotations.rotate(self.orientation, np.array(tools[name])))

    @property
    def cable_tension(self) -> Array:
        """Tension of each cable at the sample, (K, m), N; the commanded one for ideal cables."""
        return self[self.header.true_tension]

    @property
    def potential_change(self) -> Array:
        """Change of the potential energy since the first sample, (K,), J."""
        return self.potential - self._at_first("potential")

    @property
    def cable_power(self) -> Array:
        """Mean power of the cables over the period after each sample, (K,), W; last one NaN."""
        return self._quotient(self.cable_work)

    @property
    def external_power(self) -> Array:
        """Mean power of the external wrench over the period after each sample, (K,), W; last one NaN."""
        return self._quotient(self.external_work)

    @property
    def energy_residual(self) -> Array:
        """Energy gained since the first sample that is not explained by known works, (K,), J.

        It is zero up to round-off for exact integration with massless cables; otherwise it decreases with the step at
        the order of the backend. It contains the work of sources of unknown work, `header.unknown_works`.
        """
        stored = self.kinetic + self.potential
        first = self._at_first("kinetic") + self._at_first("potential")
        gained = stored - first - self.cable_work - self.external_work
        for name in self.header.further_works.values():
            gained = gained - (self[name] - self._at_first(name))
        return gained

    def summary(self) -> dict[str, Any]:
        """Return the figures that `cdpr run` prints, as plain numbers."""
        figures: dict[str, Any] = late("Run.summary")(self)
        return figures

    def plot(
        self,
        *names: str,
        cables: str | int | Sequence[str | int] | None = None,
        width: str | float | None = None,
    ) -> Figure:
        """Plot panels of the run below each other; requires the extra `plot`.

        In files (`savefig("name.pdf")`), PDF embeds fonts as TrueType and SVG has letters as outlines. The same run
        gives the same bytes.

        Args:
            names: quantities by their attribute names ("tension", "position_error", ...), "attitude", "energy",
                "power", "external_force", "external_moment", and columns of plugins; an overview by default.
            cables: cables to show in panels with a line per cable, by name or by number from 1; all by default.
            width: width for print, with 8 pt text: "ieee" (3.5 in, one column), "ieee-wide" (7.16 in), a number of
                inches, or a number with its unit, such as "88 mm"; for the screen by default.

        Raises:
            CdprError: for unknown names, with the available ones.
            PluginError: if matplotlib is not installed.
        """
        drawn: Figure = late("Run.plot")(self, names, cables, width)
        return drawn

    def to_pandas(self) -> DataFrame:
        """Return the rows as a pandas DataFrame, one column per number named with its unit, over the time `t`, s.

        The names are those of `cdpr export --to csv`: docs/columns.md.

        Raises:
            PluginError: if pandas is not installed.
        """
        frame: DataFrame = late("Run.to_pandas")(self)
        return frame

    def _repr_html_(self) -> str:
        """Return the representation in notebooks."""
        html: str = late("Run._repr_html_")(self)
        return html

    def _at_first(self, name: str) -> Array:
        """Return a one-column field at the first sample of the whole run, (1,); (0,) without rows."""
        row = self.rows[:1] if self.start is None else self.start[None]
        return row[:, self.header.layout.columns[name]][:, 0]

    def _quotient(self, values: Array) -> Array:
        """Return the difference quotients of `values` (K, ...) from each row to the next; the last is NaN."""
        quotient = np.full_like(values, np.nan)
        changes = np.diff(values, axis=0)
        if self.header.log_every == 1:
            quotient[:-1] = changes / self.header.control_step
        else:  # the last period may be shorter
            quotient[:-1] = (changes.T / np.diff(self.time)).T
        return quotient
