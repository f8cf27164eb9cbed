"""The kinds of workspaces: what is measured at a pose, and what of it counts as inside."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

from cdpr.errors import CdprError
from cdpr.model import Robot
from cdpr.nearest import did_you_mean
from cdpr.workspace import answers
from cdpr.workspace.measure import Measured
from cdpr.workspace.question import Question
from cdpr.workspace.required import NOTHING, Required

Needs = Literal["", "wrenches", "accelerations"]

HELD = ("axial_stiffness",)


@dataclass(frozen=True)
class WorkspaceKind:
    """One kind.

    Attributes:
        name: as commands have it.
        answer: what measures it.
        title: what it is, in a few words.
        value: what the value of a pose is.
        unit: of the value.
        needs: "wrenches" or "accelerations" that must be exerted, or "".
        takes: what of a question it asks for beside those.
        at_zero: whether a value of 0 counts as inside.
        held: whether a tension solver can say what is inside where W lacks rank.
        mass: whether the value is a mass that is carried beside the platform.
        programs: whether linear programs can answer it, too.
        bodies: whether what limits it are bodies, or else directions.
        proved: whether `cdpr.workspace.certify` can prove something of it.
        slope: by how much a value changes, at most, where the platform moves by a metre, with cables that leave from
            points; None where nothing tells.
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
        """Return the set that must be exerted; CdprError where another is needed."""
        if not self.needs:
            if given is not None and "required" not in self.takes:
                raise CdprError(f"{self.name}: takes no required wrenches; wrench-feasible and dynamic do")
            return given or NOTHING
        if given is None or given.accelerations != (self.needs == "accelerations"):
            raise CdprError(
                f"{self.name}: needs the set of {self.needs} that must be exerted beyond carrying the weight"
            )
        return given

    def slope_of(self, robot: Robot) -> float | None:
        """Return `slope` where it holds: on a pulley a cable turns faster than its platform moves."""
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
    raise CdprError("a workspace that was made of others is not measured")


def combined(name: str) -> WorkspaceKind:
    """Return the kind of what was made of others."""
    return WorkspaceKind(name, _never, "of two workspaces", "inside", "")


def kind_of(name: object) -> WorkspaceKind:
    """Return a kind by its name; CdprError, which names all, where there is none."""
    if not isinstance(name, str) or name not in KINDS:
        hint = did_you_mean(name, KINDS) if isinstance(name, str) else ""
        raise CdprError(f"kind: {name!r} is no kind of workspace: {hint}there are {', '.join(KINDS)}")
    return KINDS[name]
