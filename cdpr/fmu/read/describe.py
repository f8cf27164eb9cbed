"""Output of `cdpr fmu info` and `check`; no native code is loaded."""

from __future__ import annotations

import io
import warnings
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any, Literal

from cdpr.base.errors import FmuError
from cdpr.base.problems import printable
from cdpr.fmu.read import trust
from cdpr.fmu.read.archive import Archive, library
from cdpr.fmu.read.mapping import Mapping, resolve
from cdpr.fmu.read.model import Variable
from cdpr.fmu.read.options import Signals
from cdpr.fmu.read.signals import ROLES, Role
from cdpr.model import Robot


def describe(archive: Archive) -> dict[str, Any]:
    """Return plain data on an FMU."""
    about = archive.description
    return {
        "file": str(archive.path),
        "name": about.name,
        "description": about.description,
        "tool": about.tool,
        "fmi": about.fmi,
        "sha256": archive.sha256,
        "trusted": archive.sha256 in trust.trusted(),
        "token": printable(about.token),
        "platforms": list(about.platforms),
        "runs_here": _runs_here(archive),
        "sources": about.sources,
        "default_step_s": about.default_step,
        "capabilities": asdict(about.capabilities),
        "variables": [_variable(variable) for variable in about.variables],
    }


def _runs_here(archive: Archive) -> bool:
    try:
        library(archive)
    except FmuError:
        return False
    return True


def _variable(variable: Variable) -> dict[str, Any]:
    return {
        "name": variable.name,
        "value_reference": variable.value_reference,
        "kind": variable.kind,
        "causality": variable.causality,
        "variability": variable.variability,
        "shape": list(variable.shape),
        "unit": None if variable.unit is None else variable.unit.name,
        "start": None if variable.start is None else list(map(printable, variable.start)),
        "aliases": list(variable.aliases),
        "description": variable.description,
    }


@dataclass(frozen=True)
class Check:
    """Result of one check."""

    id: str
    outcome: Literal["passed", "failed", "n/a"]
    detail: str = ""


def check(archive: Archive, robot: Robot | None, role: Role | None, signals: Signals | None) -> Iterator[Check]:
    """Yield the results of the checks of an FMU with a valid archive, for `robot` if given."""
    yield Check("archive", "passed", "names, sizes and description are sound")
    try:
        yield Check("binary", "passed", library(archive))
    except FmuError as error:
        yield Check("binary", "failed", str(error))
    yield from _standard(archive)
    needs_tool = archive.description.capabilities.needs_tool
    yield Check("self_contained", "failed" if needs_tool else "passed", "needs the tool that made it" * needs_tool)
    if robot is None:
        yield Check("signals", "n/a", "no robot was given")
        return
    if role is None and signals is None and _has_controller(archive):
        text = "contains a controller and a plant (--with-controller), for other simulators; scenarios cannot use it"
        yield Check("signals", "n/a", text)
        return
    role = role or guess_role(archive, robot, signals)
    mapping, problems = resolve(archive.description, robot, signals, role)
    for problem in problems:
        yield Check("signals", "failed", problem)
    if not problems:
        yield Check("signals", "passed", "; ".join([f"as a {role}: {summary(mapping)}", *mapping.notices]))


def _standard(archive: Archive) -> Iterator[Check]:
    """Check against the letter of the standard by FMPy, which also loads no native code."""
    try:
        from fmpy.validation import validate_fmu
    except ImportError:
        yield Check("standard", "n/a", "needs FMPy: pip install 'cdpr[fmu]'")
        return
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        problems = validate_fmu(io.BytesIO(archive.content))
    for problem in problems:
        yield Check("standard", "failed", printable(" ".join(problem.split())))
    if not problems:
        yield Check("standard", "passed", f"FMI {archive.description.fmi}, by FMPy")


def _has_controller(archive: Archive) -> bool:
    """Return True for an FMU of `cdpr fmu export --with-controller`: the desired pose leads to the actual one."""
    variables = {(each.name, each.causality) for each in archive.description.variables}
    return variables >= {("desired_position", "input"), ("position", "output")}


def guess_role(archive: Archive, robot: Robot, signals: Signals | None) -> Role:
    """Return the role with the most signals found and the fewest errors, the first of ROLES if equal."""

    def merit(role: Role) -> int:
        mapping, problems = resolve(archive.description, robot, signals, role)
        return len(mapping.inputs.ports) + len(mapping.outputs.ports) - len(problems)

    return max(ROLES, key=merit)


def summary(mapping: Mapping) -> str:
    """Return the signals in and out."""
    return f"{', '.join(mapping.inputs.ports) or 'nothing'} -> {', '.join(mapping.outputs.ports) or 'nothing'}"
