"""Statements about bodies in contact."""

from __future__ import annotations

PLATFORM = "the platform"  # its name in pairs of bodies


def passing(names: str, clearance: float) -> str:
    """Return the statement that a cable passes through its platform, empty where it does not.

    A negative clearance of a cable from its own platform is no depth of contact (see `cdpr.mechanics.clearance`), so
    it is not reported.

    Args:
        names: the pair, as `Clearance.name` returns it; a remark may follow after a comma.
        clearance: of the pair, m.
    """
    pair, comma, remark = names.partition(", ")
    cable, own, end = pair.rpartition(f" and {PLATFORM}")
    return f"{cable} passes through {PLATFORM}{comma}{remark}" if clearance < 0.0 and own and not end else ""
