"""Section of an FMU between commands and cables of the plant."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from cdpr.fmu.read.options import FmuFile
from cdpr.plugins import FileName, PluginOptions


class Actuators(PluginOptions, FmuFile):
    """Winches as one FMU for all cables, with commands as inputs and tensions as outputs."""

    file: FileName | None = Field(
        None,
        description="the FMU, relative to this file; default: cdpr exports winches and elastic cables with the "
        "values of the robot and keeps them in the user's cache",
    )
    coupling: Literal["gauss_seidel", "series"] = Field(
        "gauss_seidel",
        description="series: the tensions follow from the commands alone. gauss_seidel: from lengths and rates of the "
        "cables too; once a physics step the plant moves under the tensions, and the FMU follows with its new state",
    )
    check_step: bool = Field(
        True, description="reject a physics step for which the coupling of plant and FMU is known to be unstable"
    )
