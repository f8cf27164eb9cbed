"""Export of robots as FMUs for co-simulation: one generic C++17 source, configured by the FMU's resources.

The plant is the backend `reference`, compiled from the same headers, with the same fourth-order scheme: cables and
tensions are evaluated at every stage. `Plant`, `Actuator` and `Controller` define the content, `write_fmu` writes it,
`cached_fmu` keeps it in the user's cache.
"""

from cdpr.fmu.export.actuator import Actuator
from cdpr.fmu.export.archive import cached_fmu, fmu_bytes, write_fmu
from cdpr.fmu.export.control import Control
from cdpr.fmu.export.library import NATIVE
from cdpr.fmu.export.loads import Load
from cdpr.fmu.export.models import Controller, Plant
from cdpr.fmu.export.variables import Model

__all__ = [
    "NATIVE",
    "Actuator",
    "Control",
    "Controller",
    "Load",
    "Model",
    "Plant",
    "cached_fmu",
    "fmu_bytes",
    "write_fmu",
]
