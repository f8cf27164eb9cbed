"""The C of controllers and tension solvers, for exported FMUs: it stands beside their module, under its name."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

from cdpr.errors import CdprError
from cdpr.plugins.compiled import speaks_for
from cdpr.plugins.controller import Controller
from cdpr.plugins.info import Role
from cdpr.plugins.registry import Registry
from cdpr.plugins.solver import CompiledSolver, TensionSolver


def c_file(module: str) -> Path | None:
    """Return the C beside a module, which is not loaded; None where there is none."""
    try:
        spec = find_spec(module)
    except (ImportError, ValueError):
        return None
    path = Path(spec.origin).with_suffix(".c") if spec and spec.origin else None
    return path if path and path.is_file() else None


def with_c(registry: Registry, role: Role) -> list[str]:
    """Return the names of those of a role with C beside them."""
    rows = [registry.get(role, name).info for name in registry.names(role)]
    return [row.name for row in rows if isinstance(row.factory, str) and c_file(row.factory.split(":")[0])]


def law_in_c(controller: Controller, name: str, registry: Registry) -> Path:
    """Return the C of a controller; CdprError where there is none."""
    path = c_file(type(controller).__module__)
    if path is None or controller.numbers_in_c() is None or not speaks_for(controller.numbers_in_c, controller.control):
        raise _none(name, "controller", registry)
    return path


def solve_in_c(solver: TensionSolver, name: str, registry: Registry) -> Path:
    """Return the C of a tension solver; CdprError where there is none, or it does not take the solver's options."""
    path = c_file(type(solver).__module__)
    if path is None or not isinstance(solver, CompiledSolver) or solver.parameters:
        raise _none(name, "solver", registry)
    if type(solver).solve is not CompiledSolver.solve or "solve" in vars(solver):
        raise _none(name, "solver", registry)
    return path


def _none(name: str, role: Role, registry: Registry) -> CdprError:
    known = ", ".join(with_c(registry, role))
    return CdprError(
        f"the {role} '{name}' has no C beside it, so it cannot go into an FMU; these can: {known} "
        f"(--set {role}.type=NAME)"
    )
