"""Plants from FMUs: an external FMU in its own process, or the robot as exported by cdpr.

`reset` restarts the FMU with the parameters of the scenario, the robot and the initial state. It then compares the pose
and the cables of the FMU with the scenario, so that a wrong order, frame or unit is detected at once.
"""

from __future__ import annotations

import warnings
import weakref
from dataclasses import dataclass
from typing import Any

import numpy as np

from cdpr.base import tolerances
from cdpr.base.errors import FmuError, PluginError
from cdpr.fmu.export import Plant, cached_fmu
from cdpr.fmu.read.archive import Archive, open_archive
from cdpr.fmu.read.trust import require_trust
from cdpr.fmu.run.exchange import STATE, normaliser, reader, writer
from cdpr.fmu.run.parameters import Known, robot_parameters
from cdpr.fmu.run.running import RunningFmu
from cdpr.mechanics import kinematics
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins import Backend
from cdpr.plugins.snapshots import Saved, put_back, save
from cdpr_backends.fmu_checks import INITIAL, MOST_FACTOR, NO_ANSWER, pull_fault, start_fault

MASS = "mass", "center_of_mass", "inertia"  # parameters


@dataclass(frozen=True, eq=False)
class Snapshot:
    """Number of a state saved in the FMU, and copies of the arrays."""

    number: int
    arrays: Saved


class FmuBackend(Backend):
    """Plant from one FMU with the commands as inputs and the platform's state as outputs.

    Attributes:
        fmu: file, mapping and instance.
    """

    def __init__(self, robot: Robot, gravity: Array, physics_step: float, options: Any) -> None:
        super().__init__(robot, gravity, physics_step, options)
        own = options.file is None
        archive = self._exported() if own else open_archive(options.file.path)
        if not own:
            require_trust(archive, options.sha256)
        self._ratio = self._steps_in(physics_step)
        name = f"{robot.name} as exported" if own else options.file
        step = physics_step / self._ratio
        self.fmu = RunningFmu(archive, name, "plant", robot, step, options, "inproc" if own else "process")
        self._instance = instance = self.fmu.instance
        inputs, outputs = self.fmu.mapping.inputs, self.fmu.mapping.outputs
        command = "cable_tension" if "cable_tension" in inputs.ports else "command"
        self._put_command = writer(inputs, {command: 0}, instance.inputs)
        self._put_external = writer(inputs, {"external_wrench": 0}, instance.inputs)
        self._read_state = reader(outputs, STATE, instance.outputs, self.state)
        self._normalise = normaliser(self.state)
        self._takes_wrench = "external_wrench" in inputs.ports
        self._unknown = not own  # True until the pull of its cables has been checked
        self._unwanted: list[int] = []  # saved states of snapshots that no longer exist

    def reset(self, state: Array) -> None:
        """Restart the FMU with the platform in `state` (13,)."""
        start = np.array(state, dtype=np.float64)
        self.state[:] = kinematics.make_state(np.zeros(3))  # for states that the FMU does not output
        self._put()
        self.fmu.start(self._known(start))
        self._get()
        self._check_start(start)
        if self._unknown:
            self._unknown = False
            self._check_pull(start)
            self.reset(start)

    def load(self, robot: Robot) -> None:
        """Change mass, centre of mass and inertia, which are tunable parameters of exported robots."""
        self.robot = robot
        known = robot_parameters(robot, self.gravity, self.physics_step, self.state, self.options.signals.cable_order)
        self.fmu.tune({name: known[name] for name in MASS})

    def step(self, n: int) -> None:
        """Advance by n physics steps."""
        self._put()
        self._instance.step(n * self._ratio)
        self._get()

    def engine_time(self) -> float:
        """Return the time of the FMU [s]."""
        return self._instance.time

    def snapshot(self) -> object:
        """Save the state of the FMU."""
        if not self._instance.plan.saves:
            raise PluginError(f"the FMU '{self.fmu.name}' cannot save its state (canGetAndSetFMUState is false)")
        while self._unwanted:
            self._instance.forget(self._unwanted.pop())
        snapshot = Snapshot(self._instance.save(), save(self._arrays))
        # Not released at once: the garbage collector may run during another call of the FMU.
        weakref.finalize(snapshot, self._unwanted.append, snapshot.number).atexit = False
        return snapshot

    def restore(self, snapshot: Any) -> None:
        """Restore a snapshot."""
        self._instance.restore(snapshot.number)
        put_back(snapshot.arrays, self._arrays)

    def describe(self) -> dict[str, Any]:
        """Return the file, the checksum, the mapping and the parameters."""
        return self.fmu.describe()

    def close(self) -> None:
        """Stop the FMU and its process, and delete its folder."""
        self.fmu.close()

    @property
    def _arrays(self) -> tuple[Array, ...]:
        return self.command, self.external, self.state

    def _put(self) -> None:
        self._put_command(self.command)
        if self._takes_wrench:
            self._put_external(self.external)
        elif self.external.any():
            raise PluginError(f"the FMU '{self.fmu.name}' has no input for an external wrench, but one acts")

    def _get(self) -> None:
        self._read_state()
        self._normalise()

    def _exported(self) -> Archive:
        """Return the robot as an FMU exported by cdpr; `reset` sets its state."""
        plant = Plant(self.robot, self.gravity, float(self.physics_step), kinematics.make_state(np.zeros(3)))
        archive = open_archive(cached_fmu(plant, self.options.export.fmi if self.options.export else 3))
        if archive.sha256 != archive.path.stem:
            raise FmuError(f"{archive.path}: has changed since cdpr wrote it; remove it")
        return archive

    def _steps_in(self, physics_step: float) -> int:
        """Return the number of communication steps per physics step."""
        wanted = self.options.step or physics_step
        ratio = round(physics_step / wanted)
        if ratio < 1 or abs(ratio * wanted - physics_step) > tolerances.TIME * physics_step:
            raise FmuError(
                f"backend_options.fmu.step: must be physics_step, {physics_step:g} s, divided by an integer, "
                f"got {wanted:g}"
            )
        return ratio

    def _known(self, state: Array) -> dict[str, Known]:
        """Return the values of the initial state and, if requested, of robot and step."""
        order = self.options.signals.cable_order
        known = robot_parameters(self.robot, self.gravity, self.physics_step, state, order)
        return {name: value for name, value in known.items() if self.options.from_robot or name.startswith(INITIAL)}

    def _check_start(self, start: Array) -> None:
        """Raise an error if the FMU does not start in the state of the scenario."""
        port, length = self.fmu.mapping.outputs.ports.get("cable_length"), None
        if port is not None:
            length = np.empty(self.robot.m)
            port.read(self._instance.outputs, length)
        self._refuse(start_fault(self.robot, start, self.state, length, self.fmu.filled))

    def _check_pull(self, start: Array) -> None:
        """Raise an error if the FMU's cables do not pull like those of the robot, tested in one step per cable."""
        pull = np.maximum(1.0, self.robot.tension_max - self.robot.tension_min)
        fault, share = pull_fault(self.robot, start, pull, self._answers(start, pull))
        if not fault and share < NO_ANSWER:  # cables that cannot push respond only to the opposite of a wrong sign
            fault, _ = pull_fault(self.robot, start, -pull, self._answers(start, -pull))
        self._refuse(fault)
        if share * MOST_FACTOR < 1.0:
            warnings.warn(
                f"the FMU '{self.fmu.name}' pulls {share:.2g} times as much as its cables are tensioned, in the first "
                "step: unless there are drives between, check the unit of its input, and the mass that it has",
                stacklevel=2,
            )

    def _answers(self, start: Array, pull: Array) -> Array:
        """Return the accelerations (m, 6) over one step that `pull` (m,) adds in each cable alone."""
        kept = save((self.command, self.external))
        twists = []
        for more in (np.zeros(self.robot.m), *np.diag(pull)):
            self.command[:], self.external[:] = self.robot.tension_min + more, 0.0
            self._put()
            self.fmu.start(self._known(start))
            self.step(1)
            twists.append(self.state[7:].copy())
        put_back(kept, (self.command, self.external))
        accelerations: Array = (np.array(twists[1:]) - twists[0]) / self.physics_step
        return accelerations

    def _refuse(self, fault: str) -> None:
        if fault:
            raise FmuError(f"the FMU '{self.fmu.name}' {fault}")
