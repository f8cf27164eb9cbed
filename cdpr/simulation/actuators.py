"""Winches simulated by an FMU, between the commands and the cables of any backend."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from cdpr.base.errors import CdprError, FmuError
from cdpr.cables import ACTUATED, with_model
from cdpr.cables.tables import line_table
from cdpr.fmu.export import Actuator, cached_fmu
from cdpr.fmu.read.archive import Archive, open_archive
from cdpr.fmu.read.trust import require_trust
from cdpr.fmu.run.exchange import reader, writer
from cdpr.fmu.run.parameters import Known
from cdpr.fmu.run.running import RunningFmu
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.plugins import Backend
from cdpr.plugins.registry import Registered
from cdpr.scenario import Scenario
from cdpr.scenario.actuator_schema import Actuators


def actuated(scenario: Scenario, plant: Backend, entry: Registered) -> Backend:
    """Put the scenario's actuators before a plant.

    Raises:
        CdprError: if the scenario does not allow it or the coupling would be unstable.
    """
    options, robot, step = scenario.actuators, scenario.robot, scenario.simulation.physics_step
    assert options is not None
    about = check_actuators(scenario, entry)
    own = options.file is None
    if options.file is None:
        archive = _exported(robot, step)
    else:
        archive = open_archive(options.file.path)
        require_trust(archive, options.sha256)
    name = "winches as exported" if own else options.file or ""
    fmu = RunningFmu(archive, name, "winch", robot, step, options, "inproc" if own else "process")
    lacking = {"cable_length", "cable_rate"} - set(fmu.mapping.inputs.ports)
    if options.coupling == "gauss_seidel" and len(lacking) == 2:
        fmu.close()
        raise FmuError(f"actuators: the FMU '{name}' has no input cable_length or cable_rate: set coupling: series")
    return ActuatedPlant(plant, fmu, options, about)


def check_actuators(scenario: Scenario, entry: Registered) -> dict[str, Any]:
    """Return a note on the stability of the coupling.

    Raises:
        CdprError: if the step is too long.
    """
    options = scenario.actuators
    assert options is not None
    about: dict[str, Any] = {"coupling": options.coupling, "stability": "no feedback, no oscillation"}
    return about | _stability(scenario, entry) if options.coupling == "gauss_seidel" else about


class ActuatedPlant(Backend):
    """Plant with tensions from an FMU; the communication step of both is the physics step.

    Series coupling: the FMU steps first, and its tensions act on the plant in the same step. Gauss-Seidel coupling: the
    plant steps first, under the tensions at the start of the step; the FMU follows with the lengths and rates of the
    middle of the step. With those of either end, its cables would be longer or shorter than the plant's by half a
    step's motion. The tensions at the end, and those after a new command, are read without a step.
    """

    def __init__(self, plant: Backend, fmu: RunningFmu, options: Actuators, about: dict[str, Any]) -> None:
        super().__init__(plant.robot, plant.gravity, plant.physics_step, None)
        m = plant.robot.m
        self.plant, self.fmu, self.about = plant, fmu, about
        self.state = plant.state  # live state of the plant
        self.highest = np.zeros(m)
        self._series, self._instance, self._from_robot = options.coupling == "series", fmu.instance, options.from_robot
        self._tension, self._work = np.zeros(m), 0.0
        self._cables = np.zeros((6, m)), np.zeros(m), np.zeros(m)  # W, lengths, rates
        matrix, length, rate = self._cables
        self._geometry = bind(
            "geometry", lines=line_table(plant.robot), state=self.state, matrix=matrix, length=length, rate=rate
        )
        self._past = np.zeros(m), np.zeros(m)  # lengths and rates of the previous step
        inputs, values = fmu.mapping.inputs, fmu.instance.inputs
        self._put_command = writer(inputs, {"command": 0}, values)
        self._put_length = writer(inputs, {"cable_length": 0}, values)
        self._put_rate = writer(inputs, {"cable_rate": 0}, values)
        self._get_tension = reader(fmu.mapping.outputs, {"cable_tension": 0}, fmu.instance.outputs, self._tension)

    def reset(self, state: Array) -> None:
        """Move the platform to `state` (13,), and restart the FMU with the corresponding lengths."""
        self.plant.reset(state)
        self.highest[:], self._tension[:], self._work = 0.0, 0.0, 0.0
        self._put_command(self.command)
        self._update_lengths()
        self._put_length(self._cables[1])
        self._put_rate(self._cables[2])
        self.fmu.start(_known(self.robot, self.physics_step) if self._from_robot else {})
        self._get_tension()

    def load(self, robot: Robot) -> None:
        """Change the platform of the plant."""
        self.robot = robot
        self.plant.load(robot)

    def step(self, n: int) -> None:
        """Advance both by n physics steps."""
        plant, instance, tension = self.plant, self._instance, self._tension
        (_, length, rate), (past_length, past_rate) = self._cables, self._past
        plant.external[:] = self.external
        self._put_command(self.command)
        if not self._series:
            self._refresh()
        for _ in range(n):
            if self._series:
                instance.step(1)
                self._get_tension()
            plant.command[:] = tension
            np.maximum(self.highest, np.abs(tension), out=self.highest)
            past_length[:], past_rate[:] = length, rate
            plant.step(1)
            self._update_lengths()
            self._work += float(tension @ (past_length - length))
            if not self._series:
                self._put_length(0.5 * (past_length + length))
                self._put_rate(0.5 * (past_rate + rate))
                instance.step(1)
                self._put_length(length)
                self._put_rate(rate)
                self._refresh()

    def read_tension(self, tension: Array) -> None:
        """Write the tensions (m,): of the last step in series coupling, otherwise the FMU's answer to the command."""
        if not self._series:
            self._put_command(self.command)
            self._refresh()
        tension[:] = self._tension

    def cable_work(self) -> float:
        """Return the work of the cables on the platform, J."""
        return self._work

    def engine_time(self) -> float | None:
        """Return the plant's time, s."""
        return self.plant.engine_time()

    def log(self, columns: Mapping[str, Array]) -> None:
        """Pass its columns to the plant."""
        self.plant.log(columns)

    def describe(self) -> dict[str, Any]:
        """Return metadata of plant and FMU."""
        return {**self.plant.describe(), "actuators": {**self.about, **self.fmu.describe()}}

    def close(self) -> None:
        """Close plant and FMU; may be called again."""
        try:
            self.fmu.close()
        finally:
            self.plant.close()

    def _update_lengths(self) -> None:
        """Update lengths and rates of the cables."""
        self._geometry()

    def _refresh(self) -> None:
        """Read the tensions for the present inputs."""
        self._instance.refresh()
        self._get_tension()


def _exported(robot: Robot, step: float) -> Archive:
    try:
        path = cached_fmu(_winches(robot, step))
    except CdprError as error:
        raise type(error)(
            f"actuators: without a file they are exported with the values of the robot: {error}"
        ) from error
    archive = open_archive(path)
    if archive.sha256 != archive.path.stem:
        raise FmuError(f"{archive.path}: has changed since cdpr wrote it; remove it")
    return archive


def _winches(robot: Robot, step: float) -> Actuator:
    """Return the winches that replace the robot's cables."""
    return Actuator(with_model(robot, ACTUATED), float(step))


def _complete(robot: Robot) -> bool:
    """Return whether the robot defines stiffness and winch of all cables."""
    return all(cable.winch is not None and cable.axial_stiffness is not None for cable in robot.cables)


def _known(robot: Robot, step: float) -> dict[str, Known]:
    """Return the parameters of the winches, by the names that cdpr exports."""
    if not _complete(robot):
        return {}
    return {
        variable.name: (np.reshape(variable.values, variable.shape), variable.unit)
        for variable in _winches(robot, step).variables()
        if variable.causality == "parameter"
    }


def _stability(scenario: Scenario, entry: Registered) -> dict[str, Any]:
    """Return a note on the stability limit of the step; raise CdprError beyond it, if configured."""
    from cdpr.mechanics.stability import longest, oscillator, stable

    robot, step = scenario.robot, scenario.simulation.physics_step
    if not _complete(robot):
        return {"stability": "not known: give the robot cable.axial_stiffness and winch, or compare with half the step"}
    about = oscillator(with_model(robot, ACTUATED), scenario.initial.state(), scenario.gravity)
    declared = entry.properties(scenario.backend_options(entry.info.name))  # type: ignore[arg-type]
    semi_implicit = declared.get("scheme") != "rk4"

    def scheme(h: float) -> Array:
        return about.gauss_seidel(h, robot.n, semi_implicit)

    safe = stable(scheme(step))
    limit = longest(scheme, step if not safe else 1.0)
    text = f"step * omega = {step * about.fastest:.3g}, stable up to {limit:g} s"
    if not safe and scenario.actuators is not None and scenario.actuators.check_step:
        raise CdprError(
            f"actuators: with a physics_step of {step:g} s the coupling of plant and winches, step by step, is "
            f"unstable ({text}, at the initial pose): choose a shorter simulation.physics_step, use "
            "robot.cable.model: elastic without the FMU, or set check_step: false"
        )
    return {"step_omega": step * about.fastest, "stable_up_to": limit, "stability": text}
