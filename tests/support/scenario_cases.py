"""Helpers of scenario tests: texts with every key, plugins that replace any other, ways to fail."""

from __future__ import annotations

from typing import Literal

import pytest
from pydantic import ConfigDict, Field, model_validator

from cdpr.base.errors import CdprError, PluginError, ScenarioError
from cdpr.plugins import PluginInfo, PluginOptions
from cdpr.plugins.registry import Registry
from cdpr.scenario import Scenario, load_scenario

ROBOT = """\
name: tripod
dof: [x, y, z, rx, ry, rz]
unilateral: true
platform:
  mass: 150
  inertia: [6.5, 20.0, 22.5, 0.1, 0.2, 0.3]
  center_of_mass: [0.01, 0.02, 0.03]
  shape: {box: [1.2, 0.6, 0.4]}
tension: {min: 50, max: [10000, 9000, 8000]}
cables:
- name: left
  frame: [-3.5, -2.0, 3.5]
  platform: [0.6, -0.3, -0.2]
  tension: {min: 40, max: 9500}
  diameter: 0.006
  axial_stiffness: 1e6
  linear_density: 0.15
  length: {min: 0.5, max: 12}
  speed_max: 2.5
- {frame: [3.5, -2.0, 3.5], platform: [-0.6, -0.3, 0.2]}
- {frame: [3.5, 2.0, 3.5], platform: [0.6, 0.3, -0.2]}
"""

HEAD = """\
name: every-key
world: {gravity: [0, 0, -9.81]}
simulation: {backend: plain, duration: 4.0, control_step: 0.001, physics_step: 5e-4, seed: 7}
initial:
  position: [0.0, 0.1, 1.2]
  orientation: {quaternion: [1, 0, 0, 0]}
  velocity: [0.1, 0, 0]
  angular_velocity: [0, 0.1, 0]
"""

TAIL = """\
controller: {type: gains, kp: 100, kd: [1, 2, 3, 4, 5, 6]}
solver: {type: simple, infeasible: stop}
backend_options:
  tuned: {integrator: euler, tolerance: 1e-6}
"""

POINT = """
    position: [1.5, 0.5, 1.6]
    orientation: {rpy: [0, 0, 0.3]}
    velocity: [0, 0, 0]
    angular_velocity: [0, 0, 0]
    acceleration: [0, 0, 0.5]
    angular_acceleration: [0, 0.5, 0]
"""

QUINTIC = f"""\
trajectory:
  type: quintic
  start: 0.5
  duration: 3.0
  from:{POINT}  to:{POINT.replace("{rpy: [0, 0, 0.3]}", "{euler: {angles: [0.1, 0.2, 0.3], order: XYZ}}")}"""

WAYPOINTS = f"""\
trajectory:
  type: waypoints
  start: 0.5
  points:
  - time: 1.0{POINT}  - time: 2.0{POINT}"""

HOLD = """\
trajectory:
  type: hold
  position: [1, 0, 1]
  orientation: {rpy: [0, 0, 0.1]}
"""

PICK_AND_PLACE = """\
trajectory:
  type: pick_and_place
  start: 0.5
  duration: 3.0
  height: 0.4
  vertical: 0.25
  from: {position: [0, 0, 1], orientation: {rpy: [0, 0, 0.1]}}
  to: {position: [1, 0, 1], orientation: {rpy: [0, 0, 0.2]}}
"""

HELIX = """\
trajectory:
  type: helix
  start: 0.5
  duration: 3.0
  position: [1, 0, 1]
  orientation: {rpy: [0, 0, 0.1]}
  center: [0, 0, 1]
  normal: [0, 0, 2]
  turns: 1.5
  turning: true
  pitch: 0.2
"""

JERK_LIMITED = """\
trajectory:
  type: jerk_limited
  start: 0.5
  from: {position: [0, 0, 1], orientation: {rpy: [0, 0, 0.1]}}
  points:
  - {position: [1, 0, 1], orientation: {rpy: [0, 0, 0.2]}, pause: 0.5}
  limits: {velocity: 1, acceleration: 2, jerk: 20}
  angular_limits: {velocity: 1.5, acceleration: 2.5, jerk: 25}
"""

EVENTS = """\
events:
- {type: wrench, time: 0.5, duration: 0.25, force: [100, 0, 0], moment: [0, 0, 10]}
- {type: sine, time: 1, duration: 2, force: [0, 20, 0], moment: [0, 1, 0], frequency: 2.5, phase: 0.3}
- {type: limits, time: 1.5, cable: left, min: 30, max: 5000}
- {type: cable_jam, time: 2, cable: 2, detected_after: 0.125}
- {type: cable_break, time: 2.5, cable: cable_2, detected_after: 0.0625}
- {type: target, time: 2.75, position: [1, 0, 1], orientation: {rpy: [0, 0, 0.1]}, duration: 1}
- type: target
  time: 2.8
  position: [1, 0, 1]
  limits: {velocity: 1, acceleration: 2, jerk: 20}
  angular_limits: {velocity: 1.5, acceleration: 2.5, jerk: 25}
- {type: set, time: 2.9, key: controller.kd, value: [1, 2, 3, 4, 5, 6.5]}
- {type: emergency_stop, time: 3, category: 1, stopping_time: 0.75}
"""


def whole(trajectory: str, robot: str = ROBOT) -> str:
    """Return a self-contained scenario text."""
    indented = "".join(f"  {line}\n" for line in robot.splitlines())
    return f"{HEAD}robot:\n{indented}{trajectory}{TAIL}"


BASE = whole(QUINTIC)
TEXTS = {
    "quintic": BASE,
    "waypoints": whole(WAYPOINTS),
    "hold": whole(HOLD),
    "pick_and_place": whole(PICK_AND_PLACE),
    "circle": whole(HELIX.replace("helix", "circle").replace("  pitch: 0.2\n", "")),
    "helix": whole(HELIX),
    "jerk_limited": whole(JERK_LIMITED),
    "events": whole(HOLD + EVENTS),
}


class GainsOptions(PluginOptions):
    kp: float | tuple[float, float, float, float, float, float] = Field(
        10.0, description="gain", json_schema_extra={"unit": "1/s^2"}
    )
    kd: float | tuple[float, float, float, float, float, float] = Field(5.0, json_schema_extra={"unit": "1/s"})
    limit: float | None = Field(None, ge=0, json_schema_extra={"unit": "N"})


class DampedOptions(PluginOptions):
    kp: float = Field(1.0, gt=0)
    kd: float | tuple[float, float, float, float, float, float] = 20.0


class TunedOptions(PluginOptions):
    integrator: Literal["euler", "rk4"] = "euler"
    tolerance: float = Field(1e-8, gt=0)
    label: str = ""

    @model_validator(mode="after")
    def _fits(self) -> TunedOptions:
        if self.integrator == "rk4" and self.tolerance > 0.1:
            raise ValueError("rk4 needs a tolerance of 0.1 at most")
        return self


class NeedyOptions(PluginOptions):
    path: str = Field(description="file to run")


class LaxOptions(PluginOptions):
    """Mistake of an author who wants text accepted as numbers."""

    model_config = ConfigDict(strict=False)

    gain: float = 1.0
    on: bool = False


class OddSchema(PluginOptions):
    """Its JSON Schema is none that our messages could read."""

    gain: float = 1.0

    @classmethod
    def __get_pydantic_json_schema__(cls, core_schema, handler):
        return {"properties": {"type": True}, "anyOf": [True, {"$ref": "elsewhere"}]}


class BrokenOptions(PluginOptions):
    @model_validator(mode="before")
    @classmethod
    def _explodes(cls, data: object) -> object:
        raise RuntimeError("foreign fault")


def fake_plugins() -> Registry:
    """Plugins as the installed ones might be: with and without options, not installed, and broken."""
    registry = Registry()

    def add(role, name, options=PluginOptions, requires=(), changeable=()):
        facts = {"options": options, "requires": requires, "changeable": changeable}
        info = PluginInfo(name=name, factory="nowhere:Nothing", summary="", **facts)
        registry.add(role, info, "cdpr", "0")

    add("backend", "plain")
    add("backend", "reference")
    add("backend", "tuned", TunedOptions, ("no_such_module",))
    add("backend", "needy", NeedyOptions)
    add("backend", "broken", BrokenOptions)
    add("controller", "gains", GainsOptions, changeable=("kp", "kd"))
    add("controller", "computed_torque", GainsOptions)
    add("controller", "damped", DampedOptions)
    add("controller", "none")
    add("controller", "lax", LaxOptions)
    add("controller", "odd", OddSchema)
    add("solver", "simple")
    add("solver", "qp")
    add("solver", "tuned", TunedOptions)
    return registry


PLUGINS = fake_plugins()


def load(text: str = BASE, *overrides: str, **arguments) -> Scenario:
    """Load a text under the name a.yaml with the fake plugins."""
    return load_scenario("a.yaml", text=text, overrides=overrides, plugins=PLUGINS, **arguments)


def problems(text: str = BASE, *overrides: str, **arguments) -> list[str]:
    """Return the problems of a text that must be refused."""
    with pytest.raises(CdprError) as caught:
        load(text, *overrides, **arguments)
    assert isinstance(caught.value, ScenarioError | PluginError)
    return str(caught.value).splitlines()


def problem(text: str = BASE, *overrides: str, **arguments) -> str:
    """Return the one problem of a text that must be refused."""
    found = problems(text, *overrides, **arguments)
    assert len(found) == 1, found
    return found[0]


def line_of(text: str, part: str) -> int:
    """Line, counted from 1, in which `part` first occurs."""
    return text[: text.index(part)].count("\n") + 1


def changed(text: str, old: str, new: str) -> str:
    """Replace the first `old`, which must be there."""
    assert old in text
    return text.replace(old, new, 1)
