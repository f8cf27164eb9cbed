"""The kinds of workspaces: what is measured at a pose, and what of it counts as inside."""

from __future__ import annotations

from dataclasses import dataclass

from cdpr.errors import CdprError
from cdpr.nearest import did_you_mean
from cdpr.workspace.measure import Mode
from cdpr.workspace.required import NOTHING, Required


@dataclass(frozen=True)
class WorkspaceKind:
    """One kind.

    Attributes:
        name: as commands have it.
        mode: what `measure` measures.
        title: what it is, in a few words.
        value: what the value of a pose is.
        unit: of the value.
        needs: "wrenches" or "accelerations" that must be exerted, or "".
        at_zero: whether a value of 0 counts as inside.
        held: whether it asks for one wrench alone: where W lacks rank a tension solver says whether that is possible.
    """

    name: str
    mode: Mode
    title: str
    value: str
    unit: str
    needs: str = ""
    at_zero: bool = True
    held: bool = False

    def required(self, given: Required | None) -> Required:
        """Return the set that must be exerted; CdprError where another is needed."""
        if not self.needs:
            if given is not None and self.mode != "payload":
                raise CdprError(f"{self.name}: takes no required wrenches; wrench-feasible and dynamic do")
            return given or NOTHING
        if given is None or given.accelerations != (self.needs == "accelerations"):
            raise CdprError(
                f"{self.name}: needs the set of {self.needs} that must be exerted beyond carrying the weight"
            )
        return given


KINDS = {
    kind.name: kind
    for kind in (
        WorkspaceKind("static", "margin", "static equilibrium", "capacity margin", "N", held=True),
        WorkspaceKind("wrench-feasible", "margin", "wrench-feasible", "capacity margin", "N", "wrenches"),
        WorkspaceKind("dynamic", "margin", "dynamic equilibrium", "capacity margin", "N", "accelerations"),
        WorkspaceKind("closure", "closure", "wrench closure", "least elementary vector", "", at_zero=False),
        WorkspaceKind("payload", "payload", "payload", "largest additional mass", "kg"),
    )
}


def kind_of(name: object) -> WorkspaceKind:
    """Return a kind by its name; CdprError, which names all, where there is none."""
    if not isinstance(name, str) or name not in KINDS:
        hint = did_you_mean(name, KINDS) if isinstance(name, str) else ""
        raise CdprError(f"kind: {name!r} is no kind of workspace: {hint}there are {', '.join(KINDS)}")
    return KINDS[name]
