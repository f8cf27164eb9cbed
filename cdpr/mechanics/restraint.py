"""What can be said of a robot by counting its cables. See `cdpr.model`."""

from __future__ import annotations

from cdpr.model.robot import Robot

RESTRAINTS = {
    "IRPM": "incompletely restrained positioning mechanism, m <= n",
    "CRPM": "completely restrained positioning mechanism, m = n + 1",
    "RRPM": "redundantly restrained positioning mechanism, m > n + 1",
}


def restraint(robot: Robot) -> str:
    """Return the class by number, a key of RESTRAINTS (Ming and Higuchi, Int. J. Japan Soc. Prec. Eng. 28, 1994)."""
    if robot.m <= robot.n:
        return "IRPM"
    return "CRPM" if robot.m == robot.n + 1 else "RRPM"


def few_cables(robot: Robot) -> str:
    """Return what a robot with no more cables than degrees of freedom cannot do; nothing where it has more.

    Cables only pull, so m = n of them leave some wrench unheld, whatever the pose; a load that pulls against them all,
    as gravity does of a suspended robot, keeps them taut. Legs that push need no such help.
    """
    m, n = robot.m, robot.n
    if m > n or (m == n and not robot.unilateral):
        return ""
    count = f"{m} {'cable' if robot.unilateral else 'leg'}{'s' * (m > 1)} for {n} degree{'s' * (n > 1)} of freedom"
    if m < n:
        return (
            f"{count}: at any pose some motion meets no resistance of theirs; only the load, such as gravity, limits it"
        )
    return (
        f"{count}: cables only pull, so to hold any wrench a robot needs more of them than degrees of freedom; with as "
        "many it hangs from them, and holds only what its load, such as gravity, keeps taut"
    )
