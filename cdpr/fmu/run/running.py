"""Running instance of a checked and trusted archive."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping as MappingType
from pathlib import Path
from typing import Any, Literal

from cdpr.base import tolerances
from cdpr.base.errors import FmuError
from cdpr.fmu.read.archive import Archive, extract
from cdpr.fmu.read.mapping import map_signals
from cdpr.fmu.read.options import FmuFile
from cdpr.fmu.read.ports import Side
from cdpr.fmu.read.signals import Role
from cdpr.fmu.run.folder import Folder
from cdpr.fmu.run.instance import Instance, Plan
from cdpr.fmu.run.parameters import Known, Parameters
from cdpr.model import Robot

Isolation = Literal["process", "inproc"]


class RunningFmu:
    """One FMU in one role for one robot: mapped, with an instance, not yet started.

    Args:
        archive: FMU; its trust was checked before.
        name: name for messages.
        role: role of the FMU.
        robot: robot with the exchanged signals.
        step: communication step, s.
        options: options of the scenario.
        isolation: default isolation, used if the options have none.

    Attributes:
        mapping: variables by signal.
        instance: running instance.
        filled: names of the parameters that `start` filled in.

    Raises:
        FmuError: if the FMU cannot be used in this role.
        BackendDied: if it fails.
    """

    def __init__(
        self, archive: Archive, name: str, role: Role, robot: Robot, step: float, options: FmuFile, isolation: Isolation
    ) -> None:
        self.archive, self.name, self.options = archive, name, options
        self.filled: list[str] = []
        self.isolation = options.isolation or isolation
        try:
            self.mapping = map_signals(archive.description, robot, options.signals, role)
        except FmuError as error:
            raise FmuError("\n".join(f"FMU '{name}': {line}" for line in str(error).splitlines())) from None
        for notice in self.mapping.notices:
            warnings.warn(f"FMU '{name}': {notice}", stacklevel=2)
        self.instance = self._instance(step)
        self.instance.inputs[:] = self.mapping.inputs.start()

    def start(self, known: MappingType[str, Known]) -> None:
        """Restart it with the parameters of the scenario, and its parameters among `known`."""
        parameters = Parameters(self.archive.description)
        self.filled = [name for name, (value, unit) in known.items() if parameters.fill(name, value, unit)]
        parameters.give(self.options.parameters)
        self.instance.start(parameters.settings())

    def tune(self, known: MappingType[str, Known]) -> None:
        """Change its tunable parameters among `known` between two steps."""
        parameters = Parameters(self.archive.description)
        for name, (value, unit) in known.items():
            parameters.fill(name, value, unit)
        self.instance.tune(parameters.settings())

    def describe(self) -> dict[str, Any]:
        """Return plain data for the metadata of a run."""
        about = self.archive.description
        return {
            "file": str(self.archive.path),
            "sha256": self.archive.sha256,
            "model": about.name,
            "fmi": about.fmi,
            "tool": about.tool,
            "isolation": self.isolation,
            "step": self.instance.plan.step,
            "filled": self.filled,
            "mapping": self.mapping.describe(),
        }

    def close(self) -> None:
        """Close instance, process and folder; may be called again."""
        self.instance.close()

    def _instance(self, step: float) -> Instance:
        archive, about = self.archive, self.archive.description
        check_step(archive, step)
        folder = Folder()
        try:
            library = extract(archive, folder.path)
            plan = Plan(
                name=self.name,
                fmi=about.fmi,
                token=about.token,
                library=str(library),
                resources=str(Path(folder.path).resolve() / "resources"),
                inputs=_exchanged(self.mapping.inputs),
                outputs=_exchanged(self.mapping.outputs),
                step=step,
                saves=about.capabilities.get_set_state,
                alone=about.capabilities.once_per_process,
            )
            if self.isolation == "inproc":
                from cdpr.fmu.run import slave  # loads FMPy

                return slave.make(plan, folder)
            from cdpr.fmu.run.process import Process

            return Process(plan, folder, self.options.step_timeout)
        except BaseException:
            folder.remove()
            raise


def check_step(archive: Archive, step: float) -> None:
    """Reject a communication step that the FMU does not support, and warn of a doubtful one."""
    about = archive.description
    internal = about.capabilities.fixed_internal_step
    if internal is not None and not _multiple(step, internal):
        raise FmuError(
            f"{archive.path}: its own step is {internal:g} s, and {step:g} s is not a multiple of that: choose another "
            "simulation.physics_step, or `step` among the options of the FMU"
        )
    if about.fmi == "2.0" and about.default_step is not None and step < about.default_step * (1.0 - tolerances.TIME):
        warnings.warn(
            f"{archive.path.name}: the communication step of {step:g} s is shorter than the {about.default_step:g} s "
            "that it was made for; an FMU of FMI 2 does not report a longer step of its own, and then nothing moves",
            stacklevel=2,
        )


def _multiple(step: float, of: float) -> bool:
    ratio = step / of
    return math.isfinite(ratio) and round(ratio) >= 1 and abs(ratio - round(ratio)) <= tolerances.TIME * ratio


def _exchanged(side: Side) -> tuple[tuple[int, int], ...]:
    return tuple((variable.value_reference, variable.size) for variable in side.variables)
