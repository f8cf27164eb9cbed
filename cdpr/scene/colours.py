"""Colours of figures, pages and viewers in light and dark mode.

Each colour has two variants: one for a white background and one for the dark background of pages and viewers. Both have
a contrast of at least 3 (WCAG 2.1, 1.4.11), except background fills: `BEHIND` and `SHADES`. Cable colours are distinct
for red-green blind readers; many cables also differ in dashes. The tension ramp varies lightness and hue together, so
that higher tensions contrast more with the background.
"""

from __future__ import annotations

import re
from functools import cache
from typing import NamedTuple

import numpy as np

from cdpr.model.robot import Array, frozen_array
from cdpr.tension import Status


class Pair(NamedTuple):
    """Colour "#rrggbb" for a light and for a dark background."""

    light: str
    dark: str


GROUND = Pair("#ffffff", "#15181d")
INK = Pair("#222222", "#e6e8eb")
SOFT = Pair("#6b6b6b", "#9aa3ad")
PALE = Pair("#8a8a8a", "#8d96a0")  # edges of axes and frame, and the initial pose
# For x, y and z: red, green and blue.
AXES = (Pair("#d1402a", "#ff7a63"), Pair("#00875c", "#2fc793"), Pair("#2f7fd1", "#6fb1f5"))
DESIRED_AXES = (Pair("#6b1204", "#ffc9bd"), Pair("#00452f", "#b5f2d9"), Pair("#0b2f5c", "#cfe5fc"))  # next to those
# Found by search: maximally distinct among eight colours of these hues, for all types of vision, on each background.
CABLES = (
    Pair("#4c43f4", "#6452f9"),
    Pair("#a8491b", "#aa6203"),
    Pair("#08a38b", "#3bde0d"),
    Pair("#77042c", "#f16693"),
    Pair("#540d86", "#fdc1fe"),
    Pair("#006a85", "#008995"),
    Pair("#b38d01", "#f0ec9e"),
    Pair("#a37af8", "#8b9ff7"),
)
DESIRED = Pair("#0e8a54", "#35c983")
SLACK = PALE
LIMIT = Pair("#c2008f", "#ff6bd6")
FORCE = Pair("#b35900", "#ffab4a")
SENSOR = Pair("#7a3fa0", "#d08cf5")
GOOD, BAD = Pair("#1b7f4d", "#35c983"), Pair("#c0392b", "#ff7a63")

# Platform without a colour of its own; its edges use INK.
BODY = Pair("#ccd6e3", "#6b788a")
# Background of curves: grid lines, admissible regions, ...
GRID = Pair("#e3e5e8", "#2c3138")
ADMISSIBLE = Pair("#dcefe3", "#12301f")
BEHIND = (GRID, ADMISSIBLE)
# Printed surfaces of a workspace, from steep to facing the viewer: tints of DESIRED on white paper.
SURFACE = ("#cfe7db", "#c0dfd0", "#b1d7c4", "#a2cfb9", "#93c7ad")
# ... and intervals without a valid solver result.
SHADES = {
    Status.INFEASIBLE: Pair("#f8d3cb", "#57231a"),
    Status.NOT_FOUND: Pair("#fbe7ad", "#4d3f10"),
    Status.UNSUPPORTED: Pair("#d9d9d9", "#3a3d42"),
    Status.BAD_INPUT: Pair("#dcd0ee", "#3b2f52"),
}

# Dark-mode variant of each light-mode colour.
DARK = {
    pair.light: pair.dark
    for pair in (
        *(GROUND, INK, SOFT, PALE, DESIRED, LIMIT, FORCE, SENSOR, GOOD, BAD, BODY),
        *(*AXES, *DESIRED_AXES, *CABLES, *BEHIND, *SHADES.values()),
    )
}

# Lightness, chroma and hue (degrees) in OKLCH (Ottosson 2020) at the smallest and largest tension.
RAMPS = {"light": ((0.66, 0.13, 240.0), (0.40, 0.16, 385.0)), "dark": ((0.56, 0.17, 265.0), (0.90, 0.16, 455.0))}

STEPS = 256  # of a ramp: neighbours are indistinguishable, about one byte apart

# Matrices from OKLab to the cube roots of cone responses, and from these responses to linear sRGB (Ottosson 2020).
_CONES = np.array(
    [
        [1.0, 0.3963377774, 0.2158037573],
        [1.0, -0.1055613458, -0.0638541728],
        [1.0, -0.0894841775, -1.2914855480],
    ]
)
_SRGB = np.array(
    [
        [4.0767416621, -3.3077115913, 0.2309699292],
        [-1.2684380046, 2.6097574011, -0.3413193965],
        [-0.0041960863, -0.7034186147, 1.7076147010],
    ]
)


def tension_colours(share: Array, ground: str = "dark") -> Array:
    """Return colours on the tension ramp.

    Args:
        share: (...), position between the smallest (0) and the largest tension (1); NaN counts as 0.
        ground: "light" or "dark".

    Returns:
        (..., 3), red, green and blue, 0 to 1.
    """
    part = np.clip(np.nan_to_num(np.asarray(share, dtype=float)), 0.0, 1.0)
    colours: Array = _ramp(ground)[np.rint(STEPS * part).astype(np.intp)]
    return colours


def on_either_ground(markup: str) -> str:
    """Replace light-mode colours in the styles of `markup` by CSS variables `--of-RRGGBB`, which the page may define.

    Where a page does not define them, the colours remain unchanged.
    """
    return re.sub(r"(?<=: )#[0-9a-f]{6}(?=[;\"])", _either, markup)


def _either(found: re.Match[str]) -> str:
    colour = found[0]
    return f"var(--of-{colour[1:]}, {colour})" if colour in DARK else colour


@cache
def _ramp(ground: str) -> Array:
    """Return colours (STEPS + 1, 3) from the smallest to the largest tension."""
    low, high = (np.array(end) for end in RAMPS[ground])
    part = np.linspace(0.0, 1.0, STEPS + 1)[:, None]
    lightness, chroma, hue = np.moveaxis(low + part * (high - low), -1, 0)
    angle = np.radians(hue)
    while True:
        rgb = _linear(np.stack([lightness, chroma * np.cos(angle), chroma * np.sin(angle)], axis=-1))
        outside = (rgb < -1e-4).any(axis=-1) | (rgb > 1.0 + 1e-4).any(axis=-1)
        if not outside.any():
            return frozen_array(_encoded(np.clip(rgb, 0.0, 1.0)))
        chroma = np.where(outside, 0.97 * chroma, chroma)  # outside sRGB: reduce the chroma only


def tension_steps(ground: str, count: int = 33) -> list[str]:
    """Return `count` colours "#rrggbb" from the smallest to the largest tension."""
    return [hexadecimal(rgb) for rgb in tension_colours(np.linspace(0.0, 1.0, count), ground)]


def hexadecimal(rgb: Array) -> str:
    """Return red, green and blue (3,), 0 to 1, as "#rrggbb"."""
    return "#" + "".join(f"{round(255 * float(part)):02x}" for part in rgb)


def parts(colour: str) -> tuple[float, float, float]:
    """Return red, green and blue, 0 to 1, of "#rrggbb"."""
    r, g, b = (byte / 255.0 for byte in bytes.fromhex(colour.removeprefix("#")))
    return r, g, b


def _linear(lab: Array) -> Array:
    """Return linear red, green and blue of OKLab, without matmul, whose rounding depends on the machine."""
    return _times(_SRGB, _times(_CONES, lab) ** 3)


def _times(M: Array, x: Array) -> Array:
    out: Array = x[..., 0, None] * M[:, 0] + x[..., 1, None] * M[:, 1] + x[..., 2, None] * M[:, 2]
    return out


def _encoded(linear: Array) -> Array:
    """Apply the sRGB transfer function (IEC 61966-2-1)."""
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1.0 / 2.4) - 0.055)
