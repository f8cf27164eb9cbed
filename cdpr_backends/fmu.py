"""Plants from FMUs: an external FMU in its own process, or the robot as exported by cdpr.

`reset` restarts the FMU with the parameters of the scenario, the robot and the initial state. It then compares the pose
and the cables of the FMU with the scenario, so that a wrong order, frame or unit is detected at once.
"""

from __future__ import annotations

import warnings
import weakref
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from cdpr.base import tolerances
from cdpr.base.errors import FmuError, PluginError
from cdpr.cables import chain_of, immediate, takes_lengths
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
from cdpr.plugins.backend import Operations
from cdpr.plugins.snapshots import Saved, put_back, save
from cdpr_backends.fmu_checks import INITIAL, MOST_FACTOR, NO_ANSWER, pull_fault, start_fault
from cdpr_backends.fmu_winches import FmuWinches

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
        self._winched = None if immediate(robot) else FmuWinches(robot, self.fmu, step)
        if self._winched is not None:
            self.highest = self._winched.highest
        self._takes_wrench = "external_wrench" in inputs.ports
        # True until the pull of its cables has been checked; winches that take lengths or rates are not
        self._unknown = not own and not takes_lengths(robot)
        self._start = np.zeros(13)
        self._unwanted: list[int] = []  # saved states of snapshots that no longer exist

    def reset(self, state: Array) -> None:
        """Restart the FMU with the platform in `state` (13,)."""
        start = np.array(state, dtype=np.float64)
        self._start[:] = start
        if self._winched is not None:
            self._winched.reset()
        self.state[:] = kinematics.make_state(np.zeros(3))  # for states that the FMU does not output
        self._put(begin=False)
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
        if self._winched is None:
            self._instance.step(n * self._ratio)
        else:
            self._winched.step(n * self._ratio, self.command)
        self._get()

    def read_tension(self, tension: Array) -> None:
        """Write the tension of each cable, N."""
        if self._winched is None:
            super().read_tension(tension)
        else:
            self._put()
            self._winched.read_tension(self.command, tension)

    def cable_work(self) -> float:
        """Return the work of the cables on the platform, J."""
        return super().cable_work() if self._winched is None else self._winched.work()

    def winch_readings(self, unwound: Array, unwinding: Array, torque: Array) -> Operations:
        """Return the operation that reads the winches."""
        if self._winched is None:
            return super().winch_readings(unwound, unwinding, torque)
        return [partial(self._winched.read, unwound, unwinding, torque)]

    def drum_readings(self, angle: Array, speed: Array, torque: Array, power: Array) -> Operations:
        """Return the operation that reads drums and motors."""
        return [] if self._winched is None else [partial(self._winched.read_drums, angle, speed, torque, power)]

    def bent_readings(self, unstretched: Array, bending: Array) -> Operations | None:
        """Return the operation that reads cables which sag."""
        return None if self._winched is None else [partial(self._winched.read_bending, unstretched, bending)]

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
        own = self.command, self.external, self.state
        return own if self._winched is None else (*own, *self._winched.arrays)

    def _put(self, begin: bool = True) -> None:
        """Write the inputs; `begin` is True if winches start at these commands, unless they have."""
        if self._winched is None:
            self._put_command(self.command)
        elif begin:
            self._winched.put(self.command, self._restart)
        if self._takes_wrench:
            self._put_external(self.external)
        elif self.external.any():
            raise PluginError(f"the FMU '{self.fmu.name}' has no input for an external wrench, but one acts")

    def _restart(self, lengths: dict[str, Known]) -> None:
        """Start again at the first commands of the winches, which are unwound lengths."""
        self.fmu.start({**self._known(self._start), **lengths})

    def _get(self) -> None:
        self._read_state()
        self._normalise()

    def _exported(self) -> Archive:
        """Return the robot as an FMU exported by cdpr; `reset` sets its state."""
        for cable in self.robot.cables:
            needs = chain_of(self.robot, cable).winch.needs
            if needs is not None and needs.support("plant_fmu").level == "no":
                why = needs.support("plant_fmu").why
                raise PluginError(f"the winch of cable '{cable.name}' is not supported by exported FMUs: {why}")
        state, winches = kinematics.make_state(np.zeros(3)), not immediate(self.robot)
        plant = Plant(self.robot, self.gravity, float(self.physics_step), state, winches)
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
