"""Kinds of workspaces: the measured value at a pose and the criterion for inside."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

from cdpr.analysis.workspace import answers
from cdpr.analysis.workspace.measure import Measured
from cdpr.analysis.workspace.question import Question
from cdpr.analysis.workspace.required import NOTHING, Required
from cdpr.base.errors import CdprError
from cdpr.base.nearest import did_you_mean
from cdpr.base.problems import shown
from cdpr.model import Robot

Needs = Literal["", "wrenches", "accelerations"]

HELD = ("axial_stiffness",)


@dataclass(frozen=True)
class WorkspaceKind:
    """One kind of workspace.

    Attributes:
        name: name in commands.
        answer: function that measures it.
        title: short description.
        value: name of a pose's value.
        unit: unit of the value.
        needs: required "wrenches" or "accelerations", or "".
        takes: further supported parts of a question.
        at_zero: True if a value of 0 counts as inside.
        held: True if a tension solver can decide where W is rank-deficient.
        mass: True if the value is a mass carried in addition to the platform.
        programs: True if linear programs can decide it, too.
        bodies: True if bodies limit it, otherwise directions.
        proved: True if `cdpr.analysis.workspace.certify` supports it.
        slope: largest change of the value per metre of platform motion, for cables that leave from points; None if
            unknown.
    """

    name: str
    answer: Callable[..., Measured]
    title: str
    value: str
    unit: str
    needs: Needs = ""
    takes: tuple[str, ...] = ()
    at_zero: bool = True
    held: bool = False
    mass: bool = False
    programs: bool = False
    bodies: bool = False
    proved: bool = False
    slope: float | None = None

    def required(self, given: Required | None) -> Required:
        """Return the required set.

        Raises:
            CdprError: if the kind needs another one.
        """
        if not self.needs:
            if given is not None and "required" not in self.takes:
                raise CdprError(
                    f"{self.name}: does not accept required wrenches; only wrench-feasible and dynamic accept them"
                )
            return given or NOTHING
        if given is None or given.accelerations != (self.needs == "accelerations"):
            raise CdprError(f"{self.name}: requires a set of {self.needs} in addition to the weight")
        return given

    def slope_of(self, robot: Robot) -> float | None:
        """Return `slope` if it applies; on a pulley a cable turns faster than its platform moves."""
        return None if any(cable.exit is not None and cable.exit.header for cable in robot.cables) else self.slope

    def unit_of(self, question: Question) -> str:
        """Return the unit of its values."""
        return "N m/rad" if question.direction is not None and question.direction.startswith("r") else self.unit


MARGIN, STIFFNESS = ("capacity margin", "N"), "least stiffness"

KINDS = {
    kind.name: kind
    for kind in (
        WorkspaceKind("static", answers.margin, "static equilibrium", *MARGIN, held=True, programs=True, proved=True),
        WorkspaceKind(
            "wrench-feasible",
            answers.margin,
            "wrench-feasible",
            *MARGIN,
            "wrenches",
            held=True,
            programs=True,
            proved=True,
        ),
        WorkspaceKind(
            "dynamic",
            answers.margin,
            "dynamic equilibrium",
            *MARGIN,
            "accelerations",
            held=True,
            programs=True,
            proved=True,
        ),
        WorkspaceKind(
            "closure", answers.closure, "wrench closure", "least elementary vector", "", at_zero=False, programs=True
        ),
        WorkspaceKind(
            "payload",
            answers.payload,
            "payload",
            "largest additional mass",
            "kg",
            takes=("required",),
            held=True,
            mass=True,
        ),
        WorkspaceKind("stable", answers.stable, "static stability", STIFFNESS, "N/m", takes=HELD, at_zero=False),
        WorkspaceKind(
            "ifcow",
            answers.free,
            "interference-free constant orientation",
            "least clearance",
            "m",
            takes=("diameter", "obstacles"),
            at_zero=False,
            bodies=True,
            proved=True,
            slope=1.0,
        ),
        WorkspaceKind(
            "stiffness", answers.stiff, "stiffness", STIFFNESS, "N/m", takes=(*HELD, "direction"), at_zero=False
        ),
        WorkspaceKind(
            "frequency", answers.frequency, "natural frequency", "lowest frequency", "Hz", takes=HELD, at_zero=False
        ),
        WorkspaceKind("dexterity", answers.dexterity, "dexterity", "inverse condition", ""),
    )
}


def _never(*given: Any) -> Measured:
    raise CdprError("a combined workspace cannot be evaluated")


def combined(name: str) -> WorkspaceKind:
    """Return the kind of a combined workspace."""
    return WorkspaceKind(name, _never, "of two workspaces", "inside", "")


def kind_of(name: object) -> WorkspaceKind:
    """Return a kind by its name.

    Raises:
        CdprError: if there is none, with all names.
    """
    if not isinstance(name, str) or name not in KINDS:
        hint = did_you_mean(name, KINDS) if isinstance(name, str) else ""
        raise CdprError(f"kind: unknown workspace {shown(name)}: {hint}allowed: {', '.join(KINDS)}")
    return KINDS[name]
