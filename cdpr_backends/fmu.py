"""A plant that comes as an FMU: a stranger's in a process of its own, or our own robot as cdpr exports it.

At `reset` the FMU starts anew with the parameters of the scenario, of the robot and of the initial state; what it then
says of its pose and of its cables is held against the scenario, so that a wrong order, frame or unit is found at once.
"""

from __future__ import annotations

import weakref
from dataclasses import dataclass
from typing import Any

import numpy as np

from cdpr.errors import FmuError, PluginError
from cdpr.fmu.archive import Archive, open_archive
from cdpr.fmu.exchange import STATE, normalise, reader, writer
from cdpr.fmu.export import Plant, cached_fmu
from cdpr.fmu.parameters import Known, robot_parameters
from cdpr.fmu.running import RunningFmu
from cdpr.fmu.trust import require_trust
from cdpr.model import Robot, kinematics
from cdpr.model.robot import Array
from cdpr.plugins import Backend
from cdpr_backends.snapshots import Saved, put_back, save

# m, rad, m/s, rad/s: far below what any robot's start is known to, far above what single precision and angles lose.
START_TOLERANCE = 1e-5
# Share of a cable's length: above the deflection by small pulleys, below what exchanged cables or a wrong frame make.
LENGTH_TOLERANCE = 1e-2
NORM_TOLERANCE = 1e-3  # of a quaternion, as everywhere

ELSEWHERE = "it has no parameter for that: set those that it has under `parameters`, or the scenario's `initial`"
RATIO_TOLERANCE = 1e-9  # relative; steps are decimal fractions, which floats miss by rounding

INITIAL = "initial_"  # so the parameters begin that hold the initial state
START = {
    "position": (slice(0, 3), "m"),
    "quaternion": (slice(3, 7), "1"),
    "velocity": (slice(7, 10), "m/s"),
    "angular_velocity": (slice(10, 13), "rad/s"),
}


@dataclass(frozen=True, eq=False)
class Snapshot:
    """The number of a state that the FMU keeps, and copies of our arrays."""

    number: int
    arrays: Saved


class FmuBackend(Backend):
    """One FMU with the commands as inputs and the platform's state as outputs.

    Attributes:
        fmu: file, mapping and instance.
    """

    def __init__(self, robot: Robot, gravity: Array, physics_step: float, options: Any) -> None:
        super().__init__(robot, gravity, physics_step, options)
        own = options.file is None
        archive = self._exported() if own else open_archive(options.path(options.file))
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
        self._takes_wrench = "external_wrench" in inputs.ports
        self._unwanted: list[int] = []  # states that the FMU keeps for snapshots that are gone

    def reset(self, state: Array) -> None:
        """Start the FMU anew with the platform in `state` (13,)."""
        start = np.array(state, dtype=np.float64)
        self.state[:] = kinematics.make_state(np.zeros(3))  # what the FMU does not tell
        self._put()
        self.fmu.start(self._known(start))
        self._get()
        self._check(start)

    def step(self, n: int) -> None:
        """Advance by n physics steps."""
        self._put()
        self._instance.step(n * self._ratio)
        self._get()

    def engine_time(self) -> float:
        """Return the FMU's time, s."""
        return self._instance.time

    def snapshot(self) -> object:
        """Let the FMU keep its state."""
        if not self._instance.plan.saves:
            raise PluginError(f"the FMU '{self.fmu.name}' cannot save its state (canGetAndSetFMUState is false)")
        while self._unwanted:
            self._instance.forget(self._unwanted.pop())
        snapshot = Snapshot(self._instance.save(), save(self._arrays))
        # Not freed at once: the collector may run while the FMU is being asked something else.
        weakref.finalize(snapshot, self._unwanted.append, snapshot.number).atexit = False
        return snapshot

    def restore(self, snapshot: Any) -> None:
        """Go back to a snapshot."""
        self._instance.restore(snapshot.number)
        put_back(snapshot.arrays, self._arrays)

    def describe(self) -> dict[str, Any]:
        """Return file, checksum, mapping and parameters."""
        return self.fmu.describe()

    def close(self) -> None:
        """End the FMU, its process and its folder."""
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
        normalise(self.state)

    def _exported(self) -> Archive:
        """Return the robot as an FMU of our own; its state comes with `reset`."""
        plant = Plant(self.robot, self.gravity, float(self.physics_step), kinematics.make_state(np.zeros(3)))
        archive = open_archive(cached_fmu(plant, self.options.export.fmi if self.options.export else 3))
        if archive.sha256 != archive.path.stem:
            raise FmuError(f"{archive.path}: was changed since cdpr made it; remove it")
        return archive

    def _steps_in(self, physics_step: float) -> int:
        """Return how many communication steps make a physics step."""
        wanted = self.options.step or physics_step
        ratio = round(physics_step / wanted)
        if ratio < 1 or abs(ratio * wanted - physics_step) > RATIO_TOLERANCE * physics_step:
            raise FmuError(
                f"backend_options.fmu.step: must be physics_step, {physics_step:g} s, divided by an integer, "
                f"got {wanted:g}"
            )
        return ratio

    def _known(self, state: Array) -> dict[str, Known]:
        """What can be said of the start and, if wanted, of robot and step."""
        order = self.options.signals.cable_order
        known = robot_parameters(self.robot, self.gravity, self.physics_step, state, order)
        return {name: value for name, value in known.items() if self.options.from_robot or name.startswith(INITIAL)}

    def _check(self, start: Array) -> None:
        """Raise FmuError unless the FMU is where the scenario is."""
        norm = float(np.linalg.norm(self.state[3:7]))
        if not abs(norm - 1.0) <= NORM_TOLERANCE:
            self._refuse(
                f"starts with a quaternion {_brief(self.state[3:7])} of norm {norm:.4g}, not 1: check its order"
            )
        if self.state[3:7] @ start[3:7] < 0.0:
            start[3:7] *= -1.0
        for name, (span, unit) in START.items():
            said, wanted = self.state[span], start[span]
            if not np.abs(said - wanted).max() <= START_TOLERANCE * max(1.0, float(np.abs(wanted).max())):
                can = INITIAL + name in self.fmu.filled
                self._refuse(
                    f"starts with the {name} {_brief(said)}, the scenario with {_brief(wanted)} ({unit}); "
                    + ("check the mapping of its signals and their units" if can else ELSEWHERE)
                )
        port = self.fmu.mapping.outputs.ports.get("cable_length")
        if port is not None:
            said, wanted = np.empty(self.robot.m), kinematics.lengths(self.robot, start)
            port.read(self._instance.outputs, said)
            if not (np.abs(said - wanted) <= LENGTH_TOLERANCE * wanted).all():
                self._refuse(
                    f"says that its cables are {_brief(said)} m long at the start, the robot's are {_brief(wanted)} m: "
                    "check signals.cable_order, the units, and that it is an FMU of this robot"
                )

    def _refuse(self, text: str) -> None:
        raise FmuError(f"the FMU '{self.fmu.name}' {text}")


def _brief(values: Array) -> str:
    return "[" + ", ".join(f"{value:.4g}" for value in values) + "]"
