"""Properties of a robot that follow from its number of cables. See `cdpr.model` for the conventions."""

from __future__ import annotations

from cdpr.model.robot import Robot

RESTRAINTS = {
    "IRPM": "incompletely restrained positioning mechanism, m <= n",
    "CRPM": "completely restrained positioning mechanism, m = n + 1",
    "RRPM": "redundantly restrained positioning mechanism, m > n + 1",
}


def restraint(robot: Robot) -> str:
    """Return the restraint class, a key of RESTRAINTS (Ming and Higuchi, Int. J. Japan Soc. Prec. Eng. 28, 1994)."""
    if robot.m <= robot.n:
        return "IRPM"
    return "CRPM" if robot.m == robot.n + 1 else "RRPM"


def few_cables(robot: Robot) -> str:
    """Return the limitation of a robot that has no more cables than degrees of freedom, empty if it has more.

    Cables only pull. So m = n cables cannot balance every wrench at any pose. A load against which all cables pull,
    such as the weight of a suspended robot, keeps them taut. Legs that also push do not need such a load.
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
