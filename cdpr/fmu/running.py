"""From a checked and trusted archive to a running instance."""

from __future__ import annotations

import math
import shutil
import tempfile
import warnings
from pathlib import Path
from typing import Literal

from cdpr.errors import FmuError
from cdpr.fmu.archive import Archive, extract
from cdpr.fmu.instance import Instance, Plan
from cdpr.fmu.mapping import Mapping
from cdpr.fmu.ports import Side

Isolation = Literal["process", "inproc"]

# Steps are decimal fractions, which floats miss by rounding.
RATIO_TOLERANCE = 1e-9


def run_fmu(
    archive: Archive, name: str, mapping: Mapping, step: float, isolation: Isolation, timeout: float
) -> Instance:
    """Extract an FMU that is trusted and make an instance, still to be started.

    Args:
        archive: the FMU; whether its code may run was decided before.
        name: what to call it in messages.
        mapping: which of its variables are exchanged.
        step: communication step, s.
        isolation: a process of its own, or this one.
        timeout: longest wall time of a call, s; without effect in this process.

    Raises FmuError where the FMU cannot be used so, BackendDied where it fails.
    """
    about = archive.description
    check_step(archive, step)
    folder = tempfile.mkdtemp(prefix="cdpr-fmu-")
    try:
        library = extract(archive, folder)
        plan = Plan(
            name=name,
            fmi=about.fmi,
            token=about.token,
            library=str(library),
            resources=str(Path(folder).resolve() / "resources"),
            inputs=_exchanged(mapping.inputs),
            outputs=_exchanged(mapping.outputs),
            step=step,
            saves=about.capabilities.get_set_state,
            alone=about.capabilities.once_per_process,
        )
        instance = _make(plan, folder, isolation, timeout)
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        raise
    instance.inputs[:] = mapping.inputs.start()
    return instance


def _make(plan: Plan, folder: str, isolation: Isolation, timeout: float) -> Instance:
    if isolation == "inproc":
        from cdpr.fmu import slave  # loads FMPy

        return slave.make(plan, folder)
    from cdpr.fmu.process import Process

    return Process(plan, folder, timeout)


def check_step(archive: Archive, step: float) -> None:
    """Refuse a communication step that the FMU cannot do, and warn of one that it may not do."""
    about = archive.description
    internal = about.capabilities.fixed_internal_step
    if internal is not None and not _multiple(step, internal):
        raise FmuError(
            f"{archive.path}: its own step is {internal:g} s, and {step:g} s is no multiple of that: choose another "
            "simulation.physics_step, or `step` among the options of the FMU"
        )
    if about.fmi == "2.0" and about.default_step is not None and step < about.default_step * (1.0 - RATIO_TOLERANCE):
        warnings.warn(
            f"{archive.path.name}: the communication step of {step:g} s is shorter than the {about.default_step:g} s "
            "that it was made for; an FMU of FMI 2 does not tell if its own step is longer, and then nothing moves",
            stacklevel=2,
        )


def _multiple(step: float, of: float) -> bool:
    ratio = step / of
    return math.isfinite(ratio) and round(ratio) >= 1 and abs(ratio - round(ratio)) <= RATIO_TOLERANCE * ratio


def _exchanged(side: Side) -> tuple[tuple[int, int], ...]:
    return tuple((variable.value_reference, variable.size) for variable in side.variables)
