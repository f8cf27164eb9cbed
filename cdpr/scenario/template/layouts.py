"""Cable layouts of new robots without interference: cables from the corners of a box to the platform.

Functions that yield several layouts start with the best; the others suit boxes for which it fails.

Seen from above, the cables of all layouts except `crossed_suspended` divide the area between frame and platform into
triangles and quadrilaterals: each cable joins a frame point to a platform point whose normal directions overlap. Such
lines do not cross while the platform is inside the frame and upright, at any heights. Therefore cables may cross in
height: upper ones lead to the bottom of the platform, lower ones to its top. Each cable leaves the platform through a
face that contains its anchor, so that it does not pass through the platform.

Sources: crossed upper and lower cables as in IPAnema (Pott, Cable-Driven Parallel Robots, 2018); six suspended cables
(Albus, Bostelman, Dagalakis, The NIST SPIDER, a robot crane, J. Res. NIST 97 (3), 1992); eight crossed suspended
cables, CoGiRo (Gouttefarde, Collard, Riehl, Baradat, Geometry selection of a redundantly actuated cable-suspended
parallel robot, IEEE Trans. Robotics 31 (2), 2015). The ratios were chosen with random boxes.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

Rows = list[tuple[list[float], list[float]]]  # A_i and B_i of each cable, m
Size = tuple[float, float, float]

POINT = ["x", "y", "z"]
PLANE = ["x", "z", "ry"]
SPACE = ["x", "y", "z", "rx", "ry", "rz"]

CORNERS = ((-1, -1), (1, -1), (1, 1), (-1, 1))

# Anchors on the faces of the platform, as fractions of half its width: near the middle of one side and at the end of
# the other, so that the cables of one level rotate it both ways.
NEAR = 0.25
FAR = 0.75
# Half the distance between cable ends that coincide in the six-cable layout of the literature: a fraction of half the
# width, and enough for cables of 10 mm.
SPLIT = 0.1
SPLIT_ON_FRAME = 0.02
CLEAR = 0.015  # m
# Positions of the upper anchors of crossed suspended cables, as fractions of half the depth, in order of preference:
# wide ones are stiffer, narrow ones leave more space between crossing cables.
INNER = (0.5, 0.7, 0.4, 0.3, 0.2)


def planar(frame: Size, platform: Size, *, crossed: bool) -> Rows:
    """Return four cables in vertical planes: crossed ones in front of and behind the platform."""
    (X, _, Z), (x, y, z) = _halves(frame, platform)
    turned, depth = (-1.0, y) if crossed else (1.0, 0.0)
    return [
        ([a * X, b * depth, Z + b * Z], [a * x, b * depth, turned * b * z])
        for a, b in ((-1, 1), (1, 1), (1, -1), (-1, -1))
    ]


def point(frame: Size, platform: Size, count: int) -> Rows:
    """Return three or four cables that meet in the middle of the platform's top."""
    (X, Y, Z), (_, _, z) = _halves(frame, platform)
    above = CORNERS if count == 4 else ((-1, -1), (1, -1), (0, 1))  # two corners and the middle of an edge
    return [([a * X, b * Y, 2.0 * Z], [0.0, 0.0, z]) for a, b in above]


def six(frame: Size, platform: Size) -> Rows:
    """Return six suspended cables between two triangles, one inverted, as the legs of a Stewart platform (NIST).

    The two cables of a corner are separated, so that they do not touch.
    """
    (X, Y, Z), (x, y, z) = _halves(frame, platform)
    ax, ay = _split(X, SPLIT_ON_FRAME), _split(Y, SPLIT_ON_FRAME)
    bx, by = _split(x, SPLIT), _split(y, SPLIT)
    rows: Rows = []
    for s in (-1.0, 1.0):
        rows.append(([s * ax, Y, 2.0 * Z], [s * x, 0.5 * y + by, z]))
        rows.append(([s * X, -0.5 * Y + ay, 2.0 * Z], [s * x, 0.5 * y - by, z]))
        rows.append(([s * X, -0.5 * Y - ay, 2.0 * Z], [s * bx, -y, z]))
    return rows


def seven(frame: Size, platform: Size, *, crossed: bool) -> Iterator[Rows]:
    """Yield layouts of four cables from above and three from below: two corners and the middle of an edge."""
    (X, Y, Z), (x, y, z) = _halves(frame, platform)
    upper, lower, middle = (-z, z, z) if crossed else (z, 0.0, 0.0)
    for to_front in (False, True):  # lower two to the front and upper ones to the sides, or the reverse
        rows: Rows = []
        for a, b in CORNERS:
            end = (a * x, NEAR * b * y) if to_front else (NEAR * a * x, b * y)
            rows.append(([a * X, b * Y, 2.0 * Z], [*end, upper]))
        for a in (-1, 1):
            end = (FAR * a * x, -y) if to_front else (a * x, -FAR * y)
            rows.append(([a * X, -Y, 0.0], [*end, lower]))
        yield [*rows, ([0.0, Y, 0.0], [0.0, y, middle])]


def eight(frame: Size, platform: Size, *, crossed: bool) -> Iterator[Rows]:
    """Yield layouts of four cables from above to the platform's sides, and four from below to its front and back."""
    (X, Y, Z), (x, y, z) = _halves(frame, platform)
    up = -z if crossed else z
    for share in (NEAR, FAR):
        rows: Rows = [([a * X, b * Y, 2.0 * Z], [a * x, NEAR * b * y, up]) for a, b in CORNERS]
        yield rows + [([a * X, b * Y, 0.0], [share * a * x, b * y, -up]) for a, b in CORNERS]


def suspended(frame: Size, platform: Size) -> Rows:
    """Return eight cables from above, two per corner: to the sides at the top, to front and back at the bottom."""
    (X, Y, Z), (x, y, z) = _halves(frame, platform)
    ax, ay = _split(X, SPLIT_ON_FRAME), _split(Y, SPLIT_ON_FRAME)
    rows: Rows = []
    for a, b in CORNERS:
        rows.append(([a * X, b * (Y - ay), 2.0 * Z], [a * x, NEAR * b * y, z]))
        rows.append(([a * (X - ax), b * Y, 2.0 * Z], [FAR * a * x, b * y, -z]))
    return rows


def crossed_suspended(frame: Size, platform: Size) -> Iterator[Rows]:
    """Yield CoGiRo's layout: of two crossing cables at a side, one leads to the bottom and the other to the top."""
    (X, Y, Z), (x, y, z) = _halves(frame, platform)
    ax, ay = _split(X, SPLIT_ON_FRAME), _split(Y, SPLIT_ON_FRAME)
    for inner in INNER:
        rows: Rows = []
        for a, b in CORNERS:
            first = -a * b  # at the bottom, or at the top
            depth = {-1: y, 1: inner * y}
            rows.append(([a * (X - ax), b * Y, 2.0 * Z], [-a * x, b * depth[first], first * z]))
            rows.append(([a * X, b * (Y - ay), 2.0 * Z], [a * x, -b * depth[-first], -first * z]))
        yield rows


def _halves(frame: Size, platform: Size) -> tuple[Size, Size]:
    (X, Y, Z), (x, y, z) = (0.5 * np.array(size) for size in (frame, platform))
    return (float(X), float(Y), float(Z)), (float(x), float(y), float(z))


def _split(half: float, share: float) -> float:
    return min(max(share * half, CLEAR), 0.25 * half)
