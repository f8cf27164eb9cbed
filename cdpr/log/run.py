"""A run in memory: arrays with documented shapes, and what was run."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field, fields
from functools import cached_property
from typing import TYPE_CHECKING, Any, Self, overload

import numpy as np
from numpy.typing import NDArray

from cdpr.columns import BELIEVED, FIRST, Column
from cdpr.errors import CdprError
from cdpr.lazy import late
from cdpr.log.event import Event
from cdpr.log.layout import Layout
from cdpr.model import rotations
from cdpr.model.frozen import Frozen
from cdpr.model.robot import COMMANDED, Array, ideal, read_only
from cdpr.problems import printable

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.figure import Figure
    from pandas import DataFrame

    from cdpr.log.beyond import LimitChanges
    from cdpr.log.rows import LogRows
    from cdpr.mechanics.reach import Bounds
    from cdpr.view import Subject


@dataclass(frozen=True)
class Header:
    """What was run, known before the first step; the same for equal scenario, seed and versions."""

    scenario: str
    robot: str
    backend: str
    controller: str
    solver: str
    control_step: float  # s
    physics_step: float  # s
    seed: int
    gravity: tuple[float, ...]  # (3,), m/s^2
    mass: float  # kg, of the platform
    cables: tuple[str, ...]  # names
    anchors: tuple[tuple[float, ...], ...]  # (m, 6): A_i in the world, B_i on the platform, m
    tension_min: tuple[float, ...]  # (m,), N
    tension_max: tuple[float, ...]  # (m,), N
    characteristic_length: float  # m
    shape: dict[str, Any] | None  # {kind: size} of the platform, m, as `cdpr.model.shapes` says
    versions: dict[str, str]  # of cdpr, Python and the libraries that computed
    scenario_yaml: str  # the resolved scenario
    controlled: tuple[str, ...] = ()  # directions in which the wrench is to be balanced, where not all of the robot's
    cable_model: str = COMMANDED
    log_every: int = 1  # samples from one row of the run to the next
    bounds: Bounds = ()  # of lengths and winding speeds, where there are any
    broken: tuple[tuple[int, float], ...] = ()  # cables that break, counted from 0, and when, s
    exits: tuple[dict[str, Any] | None, ...] = ()  # where cables leave the frame, where not all do at their anchors
    columns: tuple[Column, ...] = ()  # what the rows hold beyond `cdpr.columns.FIRST`
    frame: tuple[tuple[float, ...], ...] = ()  # (k, 6), edges of the robot's frame: two ends each, m, world
    colours: dict[str, str] = field(default_factory=dict)  # "#rrggbb" of "platform" and "frame", where they are given
    path: tuple[tuple[float, ...], ...] = ()  # (k, 3), m, points of the desired path that the scenario foresees
    tools: dict[str, tuple[float, ...]] = field(default_factory=dict)  # points (3,) of the platform, m, its axes
    tool: str = ""  # which of them the desired motion leads; "" for the platform's origin
    believed: str = ""  # what controller and solver believed of the robot that was not so, in a line
    limit_changes: LimitChanges = ()  # tension limits that events change

    def __repr__(self) -> str:
        return printable(f"<Header of {self.scenario} on {self.backend}: {len(self.cables)} cables, seed {self.seed}>")

    @property
    def log_step(self) -> float:
        """Time from one row of the run to the next, s."""
        return self.log_every * self.control_step

    @cached_property
    def layout(self) -> Layout:
        """Columns of the rows."""
        return Layout(len(self.cables), self.ideal_cables, self.columns)

    @property
    def ideal_cables(self) -> bool:
        """Whether the tensions of all cables are their commands."""
        return ideal(self.cable_model)

    @property
    def true_tension(self) -> str:
        """Column of the tensions that the cables have."""
        return "tension" if self.ideal_cables else "cable_tension"

    @cached_property
    def subject(self) -> Subject:
        """What of the robot is drawn."""
        from cdpr.cables import read_exits  # takes long to import
        from cdpr.view import Subject

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
        """Return a dictionary for JSON; what is new only where it says something: older versions read the rest."""
        data = {each.name: getattr(self, each.name) for each in fields(self)}
        data["columns"] = tuple(asdict(column) for column in self.columns)
        return {key: value for key, value in data.items() if key not in NEWER or value != NEWER[key]}

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> Header:
        """Undo `to_dict` after a passage through JSON."""
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


# Keys that logs of earlier versions have not, and what that meant.
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


# Ends that the scenario foresees: what such a run holds is a whole result.
FORESEEN = ("finished", "infeasible", "unanswered", "beyond_limits", "touched")

# Of the least clearance in the summary: how much it is, when, and of what.
CLEARANCE = ("clearance_min_m", "clearance_min_at_s", "clearance_min_by")


_OWN = {column.name: column for column in (*FIRST, *BELIEVED)}


class Quantity(property):
    """An array of a run by the name of its column, documented by the table of columns.

    AttributeError where the run has no such column, as those of a belief where the controller knows the robot.
    """

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

    Where the scenario's `log.step` thins the log, row k was sampled at k * log_step, the last one at the end of the
    run; `summary` and `events` count every sample all the same. Frames and signs as `cdpr.model` says. `status` is
    "finished", "ended" (as the plant asked), "diverged", "infeasible" (no admissible tensions, and the scenario says to
    stop then), "unanswered" (likewise where the solver gave no valid answer), "beyond_limits" (likewise for a cable's
    length or speed or the tension that is commanded; these two are "infeasible" in logs of earlier versions),
    "touched" (likewise where cables come too near to something), "interrupted", "failed" or
    "running" (killed while it ran). Arrays are read-only: copy what is to be changed.
    """

    header: Header
    rows: Array | LogRows  # (K, width), columns as header.layout; of a long run they are read from its log when asked
    status: str = "finished"
    message: str = ""
    events: tuple[Event, ...] = ()
    timings: dict[str, float] = field(default_factory=dict)  # s of wall time; empty when not known
    unused: tuple[str, ...] = ()  # keys of the scenario that the run did not use
    interpreted: tuple[str, ...] | None = None  # what of its steps Python did; of none they were whole blocks
    plugins: dict[str, Any] = field(default_factory=dict)  # by role, what a plugin says of itself in this run
    folder: str | None = None
    counted: dict[str, Any] | None = field(default=None, repr=False)  # figures of all samples, where rows are not all
    clearance: dict[str, Any] = field(default_factory=dict)  # the least, when and of what, as in the summary; if known
    start: Array | None = field(default=None, repr=False)  # first row of the run that this is a part of

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
    solver_status = Quantity("status")  # not of the run, but of the solver's answer
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
        """Protect the rows: who edits a result edits a copy."""
        if isinstance(self.rows, np.ndarray):
            object.__setattr__(self, "rows", read_only(self.rows))

    def __repr__(self) -> str:
        header = self.header
        return printable(f"<Run of {header.scenario} on {header.backend}: {len(self.rows)} samples, {self.status}>")

    def part(self, first: int, stop: int) -> Run:
        """Return the rows from `first` to `stop` (excluded); energies still count from the first row of all."""
        start = self.start if self.start is not None or not len(self.rows) else self.rows[0]
        return Run(self.header, self.rows[first:stop], self.status, start=start)

    def picked(self, rows: NDArray[np.int64]) -> Run:
        """Return the rows with these numbers (n,); what counts on their being neighbours does not hold of it."""
        start = self.start if self.start is not None or not len(self.rows) else self.rows[0]
        return Run(self.header, self.rows[rows], self.status, start=start)

    @property
    def span(self) -> tuple[float, float]:
        """Times of the first and the last row, s; zeros where there is none."""
        return (float(self.rows[0][0]), float(self.rows[-1][0])) if len(self.rows) else (0.0, 0.0)

    def __getitem__(self, name: str) -> Array:
        """Return a field by name: (K,) where it has one column, else (K, columns)."""
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
        """Rotation vector that turns the actual into the desired attitude, (K, 3), rad, world."""
        return rotations.between(self.orientation, self.desired_orientation)

    def tool(self, name: str) -> Array:
        """Return where a tool of the platform is, (K, 3), m, world. CdprError where there is none of this name."""
        tools = self.header.tools
        if name not in tools:
            known = f"one of {', '.join(tools)}" if tools else "none: name tools in robot.platform.tools; one"
            raise CdprError(f"tool: {known} is expected, got {name!r}")
        return np.asarray(self.position + rotations.rotate(self.orientation, np.array(tools[name])))

    @property
    def cable_tension(self) -> Array:
        """Tension in each cable at the sample, (K, m), N: with ideal cables the commanded one."""
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
        """Energy gained since the first sample that no work explains, (K,), J.

        0 but for round-off under exact integration with massless cables; of the order of the backend in its step.
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
        """Draw panels of the run under one another; needs the extra `plot`.

        Saved (`savefig("name.pdf")`), PDF has its fonts embedded as TrueType and SVG its letters as outlines; the same
        run gives the same bytes.

        Args:
            names: "tension", "position_error", ...: quantities as they are called here, "attitude", "energy", "power",
                "external_force", "external_moment", and columns of plugins; an overview unless given.
            cables: which are shown where there is a line for each, by name or by number, counted from 1; all unless
                given.
            width: for print, with letters of 8 pt: "ieee" (3.5 in, a column), "ieee-wide" (7.16 in), a number of
                inches, or one with its unit, "88 mm"; for the screen unless given.

        Raises CdprError, which says what there is, for what there is not, and PluginError without matplotlib.
        """
        drawn: Figure = late("Run.plot")(self, names, cables, width)
        return drawn

    def to_pandas(self) -> DataFrame:
        """Return the rows as a pandas DataFrame: a column for each number, named with its unit, over the time `t`, s.

        Names are those of `cdpr export --to csv`: docs/columns.md. Raises PluginError without pandas.
        """
        frame: DataFrame = late("Run.to_pandas")(self)
        return frame

    def _repr_html_(self) -> str:
        """Return what a notebook shows."""
        html: str = late("Run._repr_html_")(self)
        return html

    def _at_first(self, name: str) -> Array:
        """A field of one column at the first sample of all, (1,); of no rows (0,)."""
        row = self.rows[:1] if self.start is None else self.start[None]
        return row[:, self.header.layout.columns[name]][:, 0]

    def _quotient(self, values: Array) -> Array:
        """Changes of `values` (K, ...) from each row to the next, by the time between; the last NaN."""
        quotient = np.full_like(values, np.nan)
        changes = np.diff(values, axis=0)
        if self.header.log_every == 1:
            quotient[:-1] = changes / self.header.control_step
        else:  # the last period may be shorter
            quotient[:-1] = (changes.T / np.diff(self.time)).T
        return quotient
