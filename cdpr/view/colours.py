"""Which colour stands for what, on light and on dark ground.

Everything that is drawn in figures, pages and viewers takes its colour from here. Each is there twice: one that stands
out from white and one that stands out from the dark ground of pages and viewers, both by a contrast of at least 3 (WCAG
2.1, 1.4.11); but for what lies behind: `BEHIND` and `SHADES`. Cables differ for readers who are red-green blind, too,
and by dashes where they are many. Tension goes through lightness and hue together: what pulls harder differs more from
the ground.
"""

from __future__ import annotations

import re
from functools import cache
from typing import NamedTuple

import numpy as np

from cdpr.model.robot import Array, frozen_array
from cdpr.tension import Status


class Pair(NamedTuple):
    """A colour "#rrggbb" for light ground and one for dark ground."""

    light: str
    dark: str


GROUND = Pair("#ffffff", "#15181d")
INK = Pair("#222222", "#e6e8eb")
SOFT = Pair("#6b6b6b", "#9aa3ad")
PALE = Pair("#8a8a8a", "#8d96a0")  # edges of axes and frame, the pose that was
# Of x, y and z: red, green and blue.
AXES = (Pair("#d1402a", "#ff7a63"), Pair("#00875c", "#2fc793"), Pair("#2f7fd1", "#6fb1f5"))
DESIRED_AXES = (Pair("#6b1204", "#ffc9bd"), Pair("#00452f", "#b5f2d9"), Pair("#0b2f5c", "#cfe5fc"))  # beside those
# Found by search: as far apart as eight colours of these hues can be, to all eyes, on each ground.
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
GOOD, BAD = Pair("#1b7f4d", "#35c983"), Pair("#c0392b", "#ff7a63")

# A platform of no colour of its own; its edges are of ink.
BODY = Pair("#ccd6e3", "#6b788a")
# What lies behind curves: lines of a grid, what is admissible, ...
GRID = Pair("#e3e5e8", "#2c3138")
ADMISSIBLE = Pair("#dcefe3", "#12301f")
BEHIND = (GRID, ADMISSIBLE)
# Printed surfaces of a workspace, steep to facing the eye: tints of DESIRED on white paper.
SURFACE = ("#cfe7db", "#c0dfd0", "#b1d7c4", "#a2cfb9", "#93c7ad")
# ... and times at which a solver had no valid answer.
SHADES = {
    Status.INFEASIBLE: Pair("#f8d3cb", "#57231a"),
    Status.NOT_FOUND: Pair("#fbe7ad", "#4d3f10"),
    Status.UNSUPPORTED: Pair("#d9d9d9", "#3a3d42"),
    Status.BAD_INPUT: Pair("#dcd0ee", "#3b2f52"),
}

# What is drawn for light ground, as it is on dark ground.
DARK = {
    pair.light: pair.dark
    for pair in (
        *(GROUND, INK, SOFT, PALE, DESIRED, LIMIT, FORCE, GOOD, BAD, BODY),
        *(*AXES, *DESIRED_AXES, *CABLES, *BEHIND, *SHADES.values()),
    )
}

# Lightness, chroma and hue (degrees) in OKLCH (Ottosson 2020) at the least and the largest tension.
RAMPS = {"light": ((0.66, 0.13, 240.0), (0.40, 0.16, 385.0)), "dark": ((0.56, 0.17, 265.0), (0.90, 0.16, 455.0))}

STEPS = 256  # of a ramp: neighbours differ by less than eyes tell, and lie as near as bytes do

# From OKLab to the cube roots of cone responses, and from these responses to linear sRGB (Ottosson 2020).
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
    """Return red, green and blue, (..., 3), 0 to 1, of shares (...) of the range from the least tension to the largest.

    `ground` is "light" or "dark". What is not a number is taken as the least.
    """
    part = np.clip(np.nan_to_num(np.asarray(share, dtype=float)), 0.0, 1.0)
    colours: Array = _ramp(ground)[np.rint(STEPS * part).astype(np.intp)]
    return colours


def on_either_ground(markup: str) -> str:
    """Let a page say what our colours are on its ground, where the styles in `markup` name those for light ground.

    The page defines `--of-RRGGBB`; where none does, they stay as they are.
    """
    return re.sub(r"(?<=: )#[0-9a-f]{6}(?=[;\"])", _either, markup)


def _either(found: re.Match[str]) -> str:
    colour = found[0]
    return f"var(--of-{colour[1:]}, {colour})" if colour in DARK else colour


@cache
def _ramp(ground: str) -> Array:
    """Colours (STEPS + 1, 3) from the least to the largest tension."""
    low, high = (np.array(end) for end in RAMPS[ground])
    part = np.linspace(0.0, 1.0, STEPS + 1)[:, None]
    lightness, chroma, hue = np.moveaxis(low + part * (high - low), -1, 0)
    angle = np.radians(hue)
    while True:
        rgb = _linear(np.stack([lightness, chroma * np.cos(angle), chroma * np.sin(angle)], axis=-1))
        outside = (rgb < -1e-4).any(axis=-1) | (rgb > 1.0 + 1e-4).any(axis=-1)
        if not outside.any():
            return frozen_array(_encoded(np.clip(rgb, 0.0, 1.0)))
        chroma = np.where(outside, 0.97 * chroma, chroma)  # no screen shows it: less colourful, as light


def tension_steps(ground: str, count: int = 33) -> list[str]:
    """Return `count` colours "#rrggbb" from the least to the largest tension."""
    return [hexadecimal(rgb) for rgb in tension_colours(np.linspace(0.0, 1.0, count), ground)]


def hexadecimal(rgb: Array) -> str:
    """Return red, green and blue (3,), 0 to 1, as "#rrggbb"."""
    return "#" + "".join(f"{round(255 * float(part)):02x}" for part in rgb)


def parts(colour: str) -> tuple[float, float, float]:
    """Return red, green and blue, 0 to 1, of "#rrggbb"."""
    r, g, b = (byte / 255.0 for byte in bytes.fromhex(colour.removeprefix("#")))
    return r, g, b


def _linear(lab: Array) -> Array:
    """Linear red, green and blue of OKLab, without matmul, whose last bit depends on the machine."""
    return _times(_SRGB, _times(_CONES, lab) ** 3)


def _times(M: Array, x: Array) -> Array:
    out: Array = x[..., 0, None] * M[:, 0] + x[..., 1, None] * M[:, 1] + x[..., 2, None] * M[:, 2]
    return out


def _encoded(linear: Array) -> Array:
    """As sRGB encodes it (IEC 61966-2-1)."""
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1.0 / 2.4) - 0.055)
