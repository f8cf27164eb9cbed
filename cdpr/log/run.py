"""Run in memory: documented arrays and a description of the setup."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field, fields
from functools import cached_property
from typing import TYPE_CHECKING, Any, Self, overload

import numpy as np
from numpy.typing import NDArray

from cdpr.base.columns import FIRST, NOMINAL_COLUMNS, Column
from cdpr.base.errors import CdprError
from cdpr.base.lazy import late
from cdpr.base.problems import printable
from cdpr.log.event import Event
from cdpr.log.layout import Layout, Rows
from cdpr.model import rotations
from cdpr.model.frozen import Frozen
from cdpr.model.robot import COMMANDED, Array, ideal, read_only

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.figure import Figure
    from pandas import DataFrame

    from cdpr.log.limit_violations import LimitChanges
    from cdpr.mechanics.reach import Bounds
    from cdpr.scene import Subject


@dataclass(frozen=True)
class Header:
    """Description of a run, known before its first step; identical for equal scenario, seed and versions."""

    scenario: str
    robot: str
    backend: str
    controller: str
    solver: str
    control_step: float  # s
    physics_step: float  # s
    seed: int
    gravity: tuple[float, ...]  # (3,), m/s^2
    mass: float  # kg, mass of the platform
    cables: tuple[str, ...]  # names
    anchors: tuple[tuple[float, ...], ...]  # (m, 6): A_i in the world, B_i on the platform, m
    tension_min: tuple[float, ...]  # (m,), N
    tension_max: tuple[float, ...]  # (m,), N
    characteristic_length: float  # m
    shape: dict[str, Any] | None  # {kind: size} of the platform, m, as in `cdpr.model.shapes`
    versions: dict[str, str]  # versions of cdpr, Python and the numerical libraries
    scenario_yaml: str  # the resolved scenario
    controlled: tuple[str, ...] = ()  # controlled degrees of freedom, if not all
    cable_model: str = COMMANDED
    log_every: int = 1  # samples per row of the run
    bounds: Bounds = ()  # limits of lengths and winding speeds, if any
    broken: tuple[tuple[int, float], ...] = ()  # index and time (s) of cables that break
    exits: tuple[dict[str, Any] | None, ...] = ()  # exits of cables, if not all leave the frame at their anchors
    columns: tuple[Column, ...] = ()  # additional columns of the rows after `cdpr.base.columns.FIRST`
    frame: tuple[tuple[float, ...], ...] = ()  # (k, 6), edges of the robot's frame: two ends each, m, world
    colours: dict[str, str] = field(default_factory=dict)  # "#rrggbb" of "platform" and "frame", if given
    path: tuple[tuple[float, ...], ...] = ()  # (k, 3), m, points of the planned path
    tools: dict[str, tuple[float, ...]] = field(default_factory=dict)  # points (3,) of the platform, m, in its axes
    tool: str = ""  # tool guided by the desired motion; "" for the platform's origin
    believed: str = ""  # differences of the nominal model of controller and solver, in one line
    limit_changes: LimitChanges = ()  # changes of tension limits by events

    def __repr__(self) -> str:
        return printable(f"<Header of {self.scenario} on {self.backend}: {len(self.cables)} cables, seed {self.seed}>")

    @property
    def log_step(self) -> float:
        """Time between two rows of the run, s."""
        return self.log_every * self.control_step

    @cached_property
    def layout(self) -> Layout:
        """Columns of the rows."""
        return Layout(len(self.cables), self.ideal_cables, self.columns)

    @property
    def ideal_cables(self) -> bool:
        """True if the tensions of all cables equal their commands."""
        return ideal(self.cable_model)

    @property
    def true_tension(self) -> str:
        """Column of the true tensions."""
        return "tension" if self.ideal_cables else "cable_tension"

    @cached_property
    def subject(self) -> Subject:
        """Display data of the robot."""
        from cdpr.cables import read_exits  # takes long to import
        from cdpr.scene import Subject

        return Subject(
            cables=self.cables,
            anchors=np.array(self.anchors, dtype=np.float64).reshape(-1, 6),
            tension_min=np.array(self.tension_min, dtype=np.float64),
            tension_max=np.array(self.tension_max, dtype=np.float64),
            shape=self.shape,
            frame=np.array(self.frame, dtype=np.float64).reshape(-1, 6),
            colours=self.colours,
            exits=tuple(read_exits(self.exits)),
            broken=self.broken,
            tools=self.tools,
            led=self.tool,
        )

    def to_dict(self) -> dict[str, Any]:
        """Return a dictionary for JSON; newer keys are omitted at their defaults for older versions."""
        data = {each.name: getattr(self, each.name) for each in fields(self)}
        data["columns"] = tuple(asdict(column) for column in self.columns)
        return {key: value for key, value in data.items() if key not in NEWER or value != NEWER[key]}

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> Header:
        """Return the header of a dictionary that was stored as JSON."""
        tuples = {key: tuple(data[key]) for key in ("gravity", "cables", "tension_min", "tension_max", "controlled")}
        tables: dict[str, Any] = {
            key: data[key] for key in ("anchors", "bounds", "broken", "frame", "path") if key in data
        }
        tables = {key: tuple(tuple(row) for row in rows) for key, rows in tables.items()}
        if "limit_changes" in data:
            tables["limit_changes"] = tuple(
                (time, tuple(low), tuple(high)) for time, low, high in data["limit_changes"]
            )
        exits = tuple(data.get("exits", ()))
        if "tools" in data:
            tables["tools"] = {name: tuple(point) for name, point in data["tools"].items()}
        columns = [Column(**{**column, "places": tuple(column["places"])}) for column in data.get("columns", ())]
        return cls(**{**data, **tuples, **tables, "exits": exits, "columns": tuple(columns)})


# Keys missing in logs of earlier versions, and their defaults.
NEWER: dict[str, object] = {
    "log_every": 1,
    "bounds": (),
    "broken": (),
    "exits": (),
    "columns": (),
    "frame": (),
    "colours": {},
    "path": (),
    "tools": {},
    "tool": "",
    "believed": "",
    "limit_changes": (),
}


# Ends that the scenario foresees; such runs are complete results.
FORESEEN = ("finished", "infeasible", "unanswered", "beyond_limits", "touched")

# Smallest clearance in the summary: value, time and pair.
CLEARANCE = ("clearance_min_m", "clearance_min_at_s", "clearance_min_by")


_OWN = {column.name: column for column in (*FIRST, *NOMINAL_COLUMNS)}


class Quantity(property):
    """Documented column of a run; AttributeError if the run lacks it, such as those of a nominal model."""

    def __init__(self, name: str) -> None:
        def read(run: Run) -> Array:
            if name not in run.header.layout.fields:
                raise AttributeError(f"{name}: recorded only where the scenario says `believed`")
            return run[name]

        super().__init__(read)
        self.__doc__ = _OWN[name].sentence

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
    true_wrench = Quantity("true_wrench")
    true_margin = Quantity("true_margin")

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
            raise KeyError(f"no field is named {name!r}; there are {', '.join(layout.fields)}")
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
            raise CdprError(f"tool: {known} is expected, got {name!r}")
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
        """Energy gained since the first sample that is not explained by work, (K,), J.

        It is zero up to round-off for exact integration with massless cables; otherwise it decreases with the step at
        the order of the backend.
        """
        stored = self.kinetic + self.potential
        first = self._at_first("kinetic") + self._at_first("potential")
        return stored - first - self.cable_work - self.external_work

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
