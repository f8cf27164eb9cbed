"""Places where cables cannot hold a platform, as plain geometry tells: no tensions are computed here."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from cdpr import tolerances
from cdpr.model import DOF_NAMES, rotations
from cdpr.model.robot import Array
from cdpr.scenario.plausible.subject import Finding, Subject

# Anchors whose heights differ by less than this share of their extent hang the platform from above: it may go down any
# way, and below the lowest of others there is nothing that holds it down.
LEVEL = 0.1
# Frames from their middle: a lift in a shaft hangs 40 deep, a position in millimetres is 100 away.
FAR = 50.0
ROUND_OFF = 1e-9  # of a direction, and of the frame's extent


def no_length(subject: Subject) -> Iterator[Finding]:
    """Cables without length at home; where a run begins that is an error."""
    home = subject.robot.home
    if home is None:
        return
    for cable, chord in zip(subject.robot.cables, _chords(subject, home[:3], home[3:]), strict=True):
        if np.linalg.norm(chord) < tolerances.LENGTH:
            text = f"cable '{cable.name}' has no length here: its two anchors coincide, so it has no direction"
            yield (*subject.root, "home", "position"), text


def one_sided(subject: Subject) -> Iterator[Finding]:
    """Starts at which all cables pull to one side, and gravity not to the other: nothing holds the platform there.

    Looked at are the axes of the world and the mean direction of the cables. A load of the scenario may do it.
    """
    robot = subject.robot
    free = np.array([name in robot.dof for name in DOF_NAMES[:3]])
    if not free.any() or _may_hold(subject):
        return
    for path, position, attitude in subject.starts():
        chords = _chords(subject, position, attitude) * free
        lengths = np.linalg.norm(chords, axis=1)
        if lengths.min() < tolerances.LENGTH:
            continue
        pulls = chords / lengths[:, None]
        mean = pulls.mean(axis=0)
        size = float(np.linalg.norm(mean))
        sides = [*np.eye(3), *-np.eye(3), *([mean / size] if size > ROUND_OFF else [])]
        for side in sides:
            if np.all(pulls @ side > ROUND_OFF) and subject.gravity * free @ side > -ROUND_OFF:
                axis = "[" + ", ".join(f"{part + 0.0:.3g}" for part in side) + "]"
                count = "its cable pulls" if robot.m == 1 else f"all {robot.m} cables pull"
                yield path, f"{count} the platform along {axis} (x, y, z) here, and nothing pulls it back"
                break


def outside(subject: Subject) -> Iterator[Finding]:
    """Places beyond the frame's anchors, from where all cables pull back; only gravity pulls away from them."""
    robot, anchors = subject.robot, subject.robot.anchors[:, :3]
    if _may_hold(subject):
        return
    low, high = anchors.min(axis=0), anchors.max(axis=0)
    slack = ROUND_OFF * subject.extent + tolerances.HELD
    told: set[tuple[float, ...]] = set()
    for path, position, attitude in subject.places():
        # A platform may be longer than its frame is wide: both its origin and its centre of mass must be outside.
        mass = position + rotations.matrix(attitude) @ robot.platform.center_of_mass
        for i, axis in enumerate(DOF_NAMES[:3]):
            below = max(position[i], mass[i]) < low[i] - slack
            above = min(position[i], mass[i]) > high[i] + slack
            pulled = subject.gravity[i] * (1.0 if above else -1.0) > 0.0
            hangs = pulled and high[i] - low[i] < LEVEL * subject.extent
            if axis not in robot.dof or not (below or above) or hangs or tuple(position) in told:
                continue
            told.add(tuple(position))
            span = f"its anchors go from {axis} = {low[i]:.4g} to {high[i]:.4g} m"
            yield path, f"lies outside the frame: {span}, and here {axis} = {position[i]:.6g} m"


def beyond_reach(subject: Subject) -> Iterator[Finding]:
    """Places far from the frame, or where a cable is longer or shorter than it can be.

    What lies on a pulley counts as cable, too: of those with an exit of their own, runs alone tell.
    """
    robot = subject.robot
    moves = not {"x", "y", "z"}.isdisjoint(robot.dof)
    told: set[tuple[float, ...]] = set()
    for path, position, attitude in subject.places():
        away = float(np.linalg.norm(position - subject.middle))
        key = (*position.tolist(), *attitude.tolist())
        if key in told:
            continue
        told.add(key)
        if moves and subject.extent > 0.0 and away > FAR * subject.extent:
            text = f"{away:.4g} m from the middle of the frame's anchors, which are {subject.extent:.4g} m apart"
            yield path, f"lies beyond reach: {text}; lengths are in metres"
            continue
        for cable, chord in zip(robot.cables, _chords(subject, position, attitude), strict=True):
            length = float(np.linalg.norm(chord))
            if cable.exit is None and cable.length_max is not None and length > cable.length_max * (1.0 + ROUND_OFF):
                which = f"longer than its length.max, {cable.length_max:.6g} m"
            elif cable.exit is None and cable.length_min is not None and length < cable.length_min * (1.0 - ROUND_OFF):
                which = f"shorter than its length.min, {cable.length_min:.6g} m"
            else:
                continue
            yield path, f"lies beyond reach: cable '{cable.name}' would be {length:.6g} m long, {which}"
            break


def _chords(subject: Subject, position: Array, attitude: Array) -> Array:
    """From the platform's anchors to the frame's, (m, 3), m, world."""
    anchors = subject.robot.anchors
    return np.asarray(anchors[:, :3] - (position + anchors[:, 3:] @ rotations.matrix(attitude).T))


def _may_hold(subject: Subject) -> bool:
    """Whether something besides cables and gravity may hold the platform: a wrench of the scenario; or legs do, which
    push. Gravity that points upwards is told by itself.
    """
    events = subject.run.events if subject.run else ()
    loaded = any(event.swing(1.0) is not None for event in events)
    return loaded or not subject.robot.unilateral or subject.gravity[2] > 0.0
