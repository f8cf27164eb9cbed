"""Draw the picture that moves: a run of caroca through waypoints and back, its cables coloured by their tensions.

Run: python docs/picture.py. Plain SVG with its own animation: no script, no library, no font but the reader's. Every
colour is visible on a white and on a black page.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import cdpr
from cdpr.model import rotations

Array = NDArray[np.float64]

ROOT = Path(__file__).parent.parent
SCENARIO = ROOT / "scenarios" / "waypoints.yaml"
PICTURE = ROOT / "docs" / "caroca.svg"
LABEL = "CAROCA, a robot with eight cables, moves through waypoints and back; bars show the tension of each cable"

POINTS = [  # of a loop: it ends where it begins
    {"time": 2.0, "position": [0.0, -0.9, 1.9], "orientation": {"rpy_deg": [0, 8, -12]}},
    {"time": 4.0, "position": [1.6, 0.3, 1.1], "orientation": {"rpy_deg": [6, 0, -20]}},
    {"time": 6.0, "position": [0.2, 0.9, 0.8], "orientation": {"rpy_deg": [-8, 0, 8]}},
    {"time": 8.5, "position": [-1.5, -0.5, 1.0]},
]
DURATION = 9.0  # s
FRAMES = 90  # ten a second, straight between

WIDTH, HEIGHT = 860, 400
GREY, PATH = "#7d8590", "#8a63d2"
SLACK, TAUT = np.array([0x2F, 0x81, 0xC8]), np.array([0xDB, 0x4A, 0x1C])  # of the lowest and the highest tension
FACES = {"top": "#9aa4af", "front": "#7d8590", "side": "#69727d"}
BARS, BAR, ROW = 640.0, 170.0, 30.0  # where they begin, how long and how far apart they are, px

CAMERA = np.array([7.0, -15.0, 7.5])  # m
CENTRE = np.array([0.0, 0.0, 1.65])
ZOOM = 1080.0  # px

BOX = np.array([[x, y, z] for z in (-1, 1) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]) * [0.6, 0.3, 0.2]
CORNERS = {"top": (4, 5, 6, 7), "front": (0, 1, 5, 4), "side": (1, 2, 6, 5)}
GROUND = np.array([[-3.5, -2, 0], [3.5, -2, 0], [3.5, 2, 0], [-3.5, 2, 0]], dtype=float)


def main() -> None:
    """Write the picture."""
    PICTURE.write_text(drawn(simulated()))


def simulated() -> cdpr.Run:
    """The run that is drawn."""
    changes = {"trajectory.points": POINTS, "simulation.duration": DURATION}
    return cdpr.simulate(SCENARIO, overrides=changes)


def drawn(run: cdpr.Run) -> str:
    """The SVG of a run that ends where it began."""
    rows = np.linspace(0, len(run.time) - 1, FRAMES + 1).round().astype(int)
    R = np.array([rotations.matrix(q) for q in run.orientation[rows]])
    position, tension = run.position[rows], run.cable_tension[rows]
    anchors = np.array(run.header.anchors)
    ends = position[:, None] + np.einsum("kij,mj->kmi", R, anchors[:, 3:])
    corners = position[:, None] + np.einsum("kij,cj->kci", R, BOX)
    low, high = float(run.cable_tension.min()), float(run.cable_tension.max())
    colours = [[_colour((value - low) / (high - low)) for value in row] for row in tension.T]
    seen = {name: _facing(corners[:, list(which)]) for name, which in CORNERS.items()}
    if not all(seen.values()):
        raise SystemExit(f"another side of the platform is seen on the way: {seen}")

    parts = [*_frame(anchors[:, :3])]
    parts.append(_polygon(projected(corners[:, :4] * [1, 1, 0]), f'fill="{GREY}" fill-opacity=".28"'))
    path = " ".join(map(_point, projected(run.desired_position[:: len(run.time) // 150])))
    parts.append(f'<polyline points="{path}" fill="none" stroke="{PATH}" stroke-width="1.6" stroke-dasharray="5 4"/>')
    behind = [i for i in range(len(anchors)) if anchors[i, 1] > 0.0]
    before = [i for i in range(len(anchors)) if anchors[i, 1] <= 0.0]
    parts += [_cable(projected(anchors[i, :3]), projected(ends[:, i]), colours[i]) for i in behind]
    for name, which in CORNERS.items():
        style = f'fill="{FACES[name]}" stroke="{GREY}" stroke-width="1" stroke-linejoin="round"'
        parts.append(_polygon(projected(corners[:, list(which)]), style))
    parts += [_cable(projected(anchors[i, :3]), projected(ends[:, i]), colours[i]) for i in before]
    parts += _bars(tension, colours)
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" height="{HEIGHT}" '
        f'role="img" aria-label="{LABEL}" font-family="sans-serif" font-size="14">'
    )
    return "\n".join([head, f"<title>{LABEL}</title>", *parts, "</svg>", ""])


def projected(points: Array) -> Array:
    """Points (..., 3), m, as the camera sees them (..., 2), px."""
    ahead = CENTRE - CAMERA
    ahead = ahead / np.linalg.norm(ahead)
    right = np.cross(ahead, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    seen = np.asarray(points) - CAMERA
    depth = seen @ ahead
    across, down = seen @ right / depth, seen @ np.cross(ahead, right) / depth
    return np.stack([0.36 * WIDTH + ZOOM * across, 0.51 * HEIGHT + ZOOM * down], axis=-1)


def _facing(face: Array) -> bool:
    """Return whether a face (K, 4, 3), its corners anticlockwise from outside, is visible in all frames."""
    a, b, c = face[:, 0], face[:, 1], face[:, 2]
    return bool(np.all(np.einsum("ki,ki->k", np.cross(b - a, c - a), CAMERA - a) > 0.0))


def _frame(exits: Array) -> Iterable[str]:
    """The ground, and posts to where the cables leave."""
    ground = " ".join(map(_point, projected(GROUND)))
    style = f'fill="{GREY}" fill-opacity=".08" stroke="{GREY}"'
    yield f'<polygon points="{ground}" {style}/>'
    tops = [(x, y, 3.5) for x, y, _ in GROUND]
    ring = " ".join(map(_point, projected(np.array(tops))))
    yield f'<polygon points="{ring}" fill="none" stroke="{GREY}"/>'
    for foot, top in zip(GROUND, tops, strict=True):
        (x1, y1), (x2, y2) = projected(np.array([foot, top]))
        yield f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" stroke="{GREY}" stroke-width="2.5"/>'
    for x, y in {tuple(point) for point in projected(exits).round(1).tolist()}:
        yield f'<circle cx="{x}" cy="{y}" r="4" fill="{GREY}"/>'


def _cable(anchor: Array, ends: Array, colours: Sequence[str]) -> str:
    (x1, y1), (x2, y2) = anchor, ends[0]
    moves = [_animate("x2", [f"{x:.1f}" for x in ends[:, 0]]), _animate("y2", [f"{y:.1f}" for y in ends[:, 1]])]
    line = f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" stroke="{colours[0]}" stroke-width="2">'
    return line + "".join([*moves, _animate("stroke", colours)]) + "</line>"


def _polygon(points: Array, style: str) -> str:
    frames = [" ".join(map(_point, frame)) for frame in points]
    return f'<polygon points="{frames[0]}" {style}>{_animate("points", frames)}</polygon>'


def _bars(tension: Array, colours: Sequence[Sequence[str]]) -> Iterable[str]:
    """A bar a cable, and the scale."""
    top = 100.0 * np.ceil(tension.max() / 100.0)
    begin = 0.5 * HEIGHT - 0.5 * ROW * tension.shape[1]
    yield f'<text x="{BARS:.0f}" y="{begin - 18:.0f}" fill="{GREY}">tension of each cable, N</text>'
    for i, row in enumerate(tension.T):
        y = begin + ROW * i
        lengths = [f"{BAR * value / top:.1f}" for value in row]
        yield f'<text x="{BARS - 8:.0f}" y="{y + 14:.0f}" text-anchor="end" fill="{GREY}">{i + 1}</text>'
        bar = f'<rect x="{BARS:.0f}" y="{y:.0f}" width="{lengths[0]}" height="{ROW - 12:.0f}" fill="{colours[i][0]}">'
        yield bar + _animate("width", lengths) + _animate("fill", colours[i]) + "</rect>"
    end = begin + ROW * tension.shape[1]
    yield f'<line x1="{BARS:.0f}" y1="{end:.0f}" x2="{BARS + BAR:.0f}" y2="{end:.0f}" stroke="{GREY}"/>'
    for value in (0.0, 0.5 * top, top):
        x = BARS + BAR * value / top
        yield f'<line x1="{x:.0f}" y1="{end:.0f}" x2="{x:.0f}" y2="{end + 5:.0f}" stroke="{GREY}"/>'
        yield f'<text x="{x:.0f}" y="{end + 20:.0f}" text-anchor="middle" fill="{GREY}">{value:g}</text>'


def _animate(name: str, values: Sequence[str]) -> str:
    """The attribute's values, one a frame, over and over."""
    return f'<animate attributeName="{name}" dur="{DURATION:g}s" repeatCount="indefinite" values="{";".join(values)}"/>'


def _point(point: Array) -> str:
    return f"{point[0]:.1f},{point[1]:.1f}"


def _colour(share: float) -> str:
    return "#" + "".join(f"{round(part):02x}" for part in SLACK + share * (TAUT - SLACK))


if __name__ == "__main__":
    main()
