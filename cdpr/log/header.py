"""Header of a run: its setup, known before its first step."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field, fields
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from cdpr.base.column import Column
from cdpr.base.problems import printable
from cdpr.log.layout import Layout, implied_columns
from cdpr.model.robot import COMMANDED

if TYPE_CHECKING:
    from cdpr.log.limit_violations import LimitChanges
    from cdpr.mechanics.reach import Bounds
    from cdpr.scene import Subject
    from cdpr.sensing import Sensor

SOLIDS = "solids"  # key of a sensor that sees obstacles: their rows for the kernels
BODIES = "bodies taken and released"  # source of the energy in `load_energy`


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
    columns: tuple[Column, ...] = ()  # additional columns of the rows, without those that `cable_model` implies
    frame: tuple[tuple[float, ...], ...] = ()  # (k, 6), edges of the robot's frame: two ends each, m, world
    colours: dict[str, str] = field(default_factory=dict)  # "#rrggbb" of "platform" and "frame", if given
    path: tuple[tuple[float, ...], ...] = ()  # (k, 3), m, points of the planned path
    tools: dict[str, tuple[float, ...]] = field(default_factory=dict)  # points (3,) of the platform, m, in its axes
    tool: str = ""  # tool guided by the desired motion; "" for the platform's origin
    believed: str = ""  # differences of the nominal model of controller and solver, in one line
    limit_changes: LimitChanges = ()  # changes of tension limits by events
    spans: tuple[dict[str, Any] | None, ...] = ()  # spans of cables that sag, if any
    sensors: tuple[dict[str, Any], ...] = ()  # sections of the sensors, each with its name
    imaging: dict[str, Any] = field(default_factory=dict)  # obstacles that cameras show; empty without cameras
    estimator: str = ""  # "" without one
    works: tuple[tuple[str, str], ...] = ()  # further sources of work, each with its column; "" if it is unknown

    def __repr__(self) -> str:
        return printable(f"<Header of {self.scenario} on {self.backend}: {len(self.cables)} cables, seed {self.seed}>")

    @property
    def log_step(self) -> float:
        """Time between two rows of the run, s."""
        return self.log_every * self.control_step

    @cached_property
    def layout(self) -> Layout:
        """Columns of the rows."""
        return Layout(len(self.cables), implied_columns(self.cable_model) + self.columns)

    @property
    def ideal_cables(self) -> bool:
        """True if the tensions of all cables equal their commands."""
        return self.layout.ideal

    @property
    def loaded(self) -> bool:
        """True if events may change the mass of the platform."""
        return self.layout.has("loaded")

    @property
    def further_works(self) -> dict[str, str]:
        """Columns of known works by their sources, besides `cable_work` and `external_work`."""
        loads = {BODIES: "load_energy"} if self.loaded else {}
        return loads | {source: column for source, column in self.works if column}

    @property
    def unknown_works(self) -> list[str]:
        """Sources of unknown work."""
        return [source for source, column in self.works if not column]

    @property
    def takes_lengths(self) -> bool:
        """True if winches take lengths or rates: commanded tensions are then those that nominal cables have at rest."""
        return self.layout.has("drums")

    @property
    def true_tension(self) -> str:
        """Column of the true tensions."""
        return "tension" if self.ideal_cables else "cable_tension"

    @cached_property
    def sensor_objects(self) -> tuple[Sensor, ...]:
        """Sensors.

        Raises:
            ValueError: if this version does not have the type of a sensor, or one of its keys.
        """
        if not self.sensors:
            return ()
        from pydantic import ValidationError  # takes long to import

        from cdpr.sensing import SENSORS

        sections = [{key: value for key, value in each.items() if key != SOLIDS} for each in self.sensors]
        found = []
        for each in sections:
            try:
                found.append(SENSORS.read(each))
            except ValidationError as error:
                why = error.errors()[0]["msg"] if each["type"] in SENSORS else "unknown type"
                raise ValueError(f"sensor '{each['name']}' of the type {each['type']}: {why}") from None
        return tuple(found)

    @cached_property
    def subject(self) -> Subject:
        """Display data of the robot."""
        from cdpr.cables import read_exits  # takes long to import
        from cdpr.scene import Subject

        extent = float(np.linalg.norm(np.ptp(np.array(self.anchors)[:, :3], axis=0))) or self.characteristic_length
        drawings = [sensor.drawing(extent) for sensor in self.sensor_objects]
        return Subject(
            cables=self.cables,
            anchors=np.array(self.anchors, dtype=np.float64).reshape(-1, 6),
            tension_min=np.array(self.tension_min, dtype=np.float64),
            tension_max=np.array(self.tension_max, dtype=np.float64),
            shape=self.shape,
            frame=np.array(self.frame, dtype=np.float64).reshape(-1, 6),
            colours=self.colours,
            exits=tuple(read_exits(self.exits)),
            spans=self.spans,
            gravity=self.gravity,
            broken=self.broken,
            tools=self.tools,
            sensors=tuple(each for each in drawings if each is not None),
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
            key: data[key] for key in ("anchors", "bounds", "broken", "frame", "path", "works") if key in data
        }
        tables = {key: tuple(tuple(row) for row in rows) for key, rows in tables.items()}
        if "limit_changes" in data:
            tables["limit_changes"] = tuple(
                (time, tuple(low), tuple(high)) for time, low, high in data["limit_changes"]
            )
        exits, spans = tuple(data.get("exits", ())), tuple(data.get("spans", ()))
        tables["sensors"] = tuple(data.get("sensors", ()))
        if "tools" in data:
            tables["tools"] = {name: tuple(point) for name, point in data["tools"].items()}
        columns = [Column(**{**column, "places": tuple(column["places"])}) for column in data.get("columns", ())]
        return cls(**{**data, **tuples, **tables, "exits": exits, "spans": spans, "columns": tuple(columns)})


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
    "works": (),
    "spans": (),
    "sensors": (),
    "imaging": {},
    "estimator": "",
}
