"""Drives an exported FMU through FMPy, FMI 2 and 3 alike, variables by their names as whole arrays."""

from __future__ import annotations

import ctypes
import shutil
from pathlib import Path
from types import TracebackType

import fmpy
import numpy as np
from fmpy import fmi2
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave
from fmpy.logging import addLoggerProxy

__all__ = ["Driver", "FMICallException"]

STATE = ("position", "quaternion", "velocity", "angular_velocity")


class Driver:
    """One instance; a context manager that frees it and removes what was extracted.

    `parameters` are set before the initialization mode; `during` in it.
    """

    def __init__(
        self,
        path: Path,
        parameters: dict[str, object] | None = None,
        during: dict[str, object] | None = None,
        *,
        folder: Path | None = None,
        start: float = 0.0,
    ) -> None:
        self.folder = Path(fmpy.extract(str(path), unzipdir=None if folder is None else str(folder)))
        about = fmpy.read_model_description(str(self.folder))
        self.fmi = 2 if about.fmiVersion == "2.0" else 3
        self.references: dict[str, list[int]] = {}
        self.sizes: dict[str, int] = {}
        for variable in about.modelVariables:
            name = variable.name.split("[")[0]
            self.references.setdefault(name, []).append(variable.valueReference)
            size = int(np.prod([int(d.start) for d in variable.dimensions] or [1]))
            self.sizes[name] = self.sizes.get(name, 0) + size
        self.fmu = (FMU2Slave if self.fmi == 2 else FMU3Slave)(
            guid=about.guid if self.fmi == 2 else about.instantiationToken,
            unzipDirectory=str(self.folder),
            modelIdentifier=about.coSimulation.modelIdentifier,
        )
        if self.fmi == 2:  # FMPy's proxy, which formats messages, serves whom it was given last: that may be cdpr's own
            fmi2.defaultCallbacks.logger = fmi2.fmi2CallbackLoggerTYPE(fmi2.printLogMessage)
            addLoggerProxy(ctypes.byref(fmi2.defaultCallbacks))
        self.fmu.instantiate()
        self.initialise(parameters or {}, during or {}, start)

    def initialise(self, parameters: dict[str, object], during: dict[str, object], start: float = 0.0) -> None:
        for name, value in parameters.items():
            self.set(name, value)
        if self.fmi == 2:
            self.fmu.setupExperiment(startTime=start)
            self.fmu.enterInitializationMode()
        else:
            self.fmu.enterInitializationMode(startTime=start)
        for name, value in during.items():
            self.set(name, value)
        self.at_start = self.state()  # already what the parameters make it
        self.fmu.exitInitializationMode()

    def __enter__(self) -> Driver:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.fmu.freeInstance()
        shutil.rmtree(self.folder)

    def set(self, name: str, value: object) -> None:
        values = np.ravel(value).tolist()
        (self.fmu.setReal if self.fmi == 2 else self.fmu.setFloat64)(self.references[name], values)

    def get(self, name: str) -> np.ndarray:
        if self.fmi == 2:
            return np.array(self.fmu.getReal(self.references[name]))
        return np.array(self.fmu.getFloat64(self.references[name], nValues=self.sizes[name]))

    def state(self) -> np.ndarray:
        """Pose and twist (13,), empty of winches alone."""
        return np.concatenate([np.empty(0), *(self.get(name) for name in STATE if name in self.references)])

    def step(self, time: float, duration: float) -> None:
        self.fmu.doStep(time, duration)

    def save(self) -> object:
        return self.fmu.getFMUState() if self.fmi == 3 else self.fmu.getFMUstate()

    def restore(self, saved: object) -> None:
        self.fmu.setFMUState(saved) if self.fmi == 3 else self.fmu.setFMUstate(saved)

    def free(self, saved: object) -> None:
        self.fmu.freeFMUState(saved) if self.fmi == 3 else self.fmu.freeFMUstate(saved)

    def serialise(self, saved: object) -> bytes:
        return self.fmu.serializeFMUState(saved) if self.fmi == 3 else self.fmu.serializeFMUstate(saved)

    def deserialise(self, content: bytes) -> object:
        return self.fmu.deserializeFMUState(content) if self.fmi == 3 else self.fmu.deSerializeFMUstate(content)
