"""Statements about bodies in contact."""

from __future__ import annotations

PLATFORM = "the platform"  # name of the platform in pairs of bodies


def passing(names: str, clearance: float) -> str:
    """Return the statement that a cable passes through its platform, empty if it does not.

    A negative clearance of a cable from its own platform is not a penetration depth (see `cdpr.mechanics.clearance`),
    so the statement contains no number.

    Args:
        names: names of the pair, as `Clearance.name` returns them; a remark may follow after a comma.
        clearance: clearance of the pair [m].
    """
    pair, comma, remark = names.partition(", ")
    cable, own, end = pair.rpartition(f" and {PLATFORM}")
    return f"{cable} passes through {PLATFORM}{comma}{remark}" if clearance < 0.0 and own and not end else ""
