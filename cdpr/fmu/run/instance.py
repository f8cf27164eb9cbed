"""Interface of a running FMU, in this process or in a separate one."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cdpr.fmu.run.folder import Folder
from cdpr.model.robot import Array

Value = float | int | bool | str


@dataclass(frozen=True)
class Plan:
    """Data for a new instance; plain, so that it can be sent to another process.

    `inputs` and `outputs` list variables of double precision as (value reference, number of elements).
    """

    name: str
    fmi: str  # "2.0" or "3.0"
    token: str
    library: str  # path of the extracted library
    resources: str  # path of the folder beside it, which may not exist
    inputs: tuple[tuple[int, int], ...]
    outputs: tuple[tuple[int, int], ...]
    step: float  # communication step, s
    saves: bool  # whether it can save and restore its state
    alone: bool = False  # whether a process may hold only one instance


@dataclass(frozen=True)
class Setting:
    """Start values of one variable, all its elements."""

    kind: str  # as the standard names it: Real, Integer, ... (FMI 2), Float64, Int32, ... (FMI 3)
    reference: int
    values: tuple[Value, ...]


class Instance(ABC):
    """One co-simulation FMU with a constant communication step. It owns `folder`, its extracted files.

    The caller writes `inputs`, which are constant over the next steps, and reads `outputs`, both in the FMU's own units
    and order. The arrays are made here and never replaced.

    Attributes:
        inputs: (sum of the input sizes,).
        outputs: (sum of the output sizes,), live: current after `start`, `step`, `refresh` and `restore`.
        steps: number of steps since `start`.

    Raises:
        FmuError: by every method if the FMU cannot be used.
        BackendDied: by every method if the FMU fails or its process ends; the instance can then only be closed.
        PlantEnded: by every method if the FMU requests the end of the simulation; likewise.
    """

    def __init__(self, plan: Plan, folder: Folder | None) -> None:
        self.plan = plan
        self._folder = folder
        self.inputs: Array = np.zeros(sum(size for _, size in plan.inputs))
        self.outputs: Array = np.zeros(sum(size for _, size in plan.outputs))
        self.steps = 0

    @property
    def time(self) -> float:
        """Return the FMU's time, s: a product, because a sum of steps would drift."""
        return self.steps * self.plan.step

    @abstractmethod
    def start(self, settings: Sequence[Setting]) -> None:
        """Initialise at time zero with these start values and the present inputs."""

    @abstractmethod
    def step(self, n: int) -> None:
        """Advance by n communication steps."""

    @abstractmethod
    def refresh(self) -> None:
        """Read the outputs for the present inputs without a step."""

    @abstractmethod
    def tune(self, settings: Sequence[Setting]) -> None:
        """Change tunable parameters between two steps, and read the outputs."""

    @abstractmethod
    def save(self) -> int:
        """Save the present state and return its number."""

    @abstractmethod
    def restore(self, number: int) -> None:
        """Restore a saved state; `inputs` do not change."""

    @abstractmethod
    def forget(self, number: int) -> None:
        """Free a saved state."""

    def close(self) -> None:
        """Free everything, the folder included; may be called again."""
        try:
            self.end()
        finally:
            if self._folder is not None:
                self._folder.remove()

    @abstractmethod
    def end(self) -> None:
        """Free the FMU; may be called again."""
