"""Column of the rows of a run."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from cdpr.base.problems import short_repr

CABLES = 0  # width of a column with one number per cable
WORLD, PLATFORM = "world", "platform"  # frames

ARRAY = "std_msgs/Float64MultiArray"
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,30}")  # a valid MATLAB field of at most 31 characters
# Components of quantities with a frame, by width: vector, quaternion, wrench, error of a state.
_COMPONENTS = {
    3: ("x", "y", "z"),
    4: ("w", "x", "y", "z"),
    6: ("force_x", "force_y", "force_z", "moment_x", "moment_y", "moment_z"),
    12: tuple(f"{each}_{axis}" for each in ("position", "rotation", "velocity", "angular_velocity") for axis in "xyz"),
}


@dataclass(frozen=True)
class Column:
    """Logged quantity: one number, several numbers, or one number per cable.

    Attributes:
        name: a letter, then up to 30 letters, digits and _.
        width: number of values, or `CABLES`.
        unit: SI, "" for none; for a wrench those of force and moment, "N, N m", and for the error of a state those of
            its four vectors.
        text: short description, as the beginning of a sentence.
        frame: axes of a vector (width 3), a quaternion w, x, y, z (4), a wrench (6) or an error of position, rotation,
            velocity and angular velocity (12); "" for all others.
        places: topics of the log and fields of their messages, "/TOPIC/FIELD"; a separate topic by default. If two
            columns share a place that is no array, the later one is stored.
        owner: role of the plugin that writes it; "" for columns of cdpr.

    Raises:
        ValueError, TypeError: if an attribute is invalid.

    Example:
        >>> from cdpr.plugins import CABLES, Column
        >>> column = Column("temperature", CABLES, "K", "Temperature of each winch")
        >>> column.shape, column.sentence
        ('(K, m)', 'Temperature of each winch, (K, m), K.')
    """

    name: str
    width: int
    unit: str
    text: str
    frame: str = ""
    places: tuple[str, ...] = ()
    owner: str = ""

    def __post_init__(self) -> None:
        """Check the attributes."""
        for key in ("name", "unit", "text", "frame", "owner"):
            if not isinstance(getattr(self, key), str):
                raise TypeError(f"{key} of a column must be a text, got {short_repr(getattr(self, key))}")
        if not isinstance(self.places, tuple) or not all(isinstance(place, str) for place in self.places):
            raise TypeError(f"places of a column must be a tuple of texts, got {short_repr(self.places)}")
        if not _NAME.fullmatch(self.name):
            raise ValueError(
                f"the name of a column must be a letter and up to 30 letters, digits and _, got {short_repr(self.name)}"
            )
        if not isinstance(self.width, int) or isinstance(self.width, bool) or self.width < 0:
            raise ValueError(
                f"column '{self.name}': width must be a number from 1 on, or CABLES, got {short_repr(self.width)}"
            )
        if self.frame and self.width not in _COMPONENTS:
            raise ValueError(
                f"column '{self.name}': only a vector (3), a quaternion (4), a wrench (6) and the error of a state "
                f"(12) have a frame, got a width of {self.width}"
            )
        if ", " in self.unit and not (self.frame and self.width in (6, 12)):
            raise ValueError(
                f"column '{self.name}': only a wrench and the error of a state have several units, got "
                f"{short_repr(self.unit)}"
            )

    @property
    def topics(self) -> tuple[tuple[str, str], ...]:
        """Topics of the log and the fields of their messages that hold it."""
        own = f"/cdpr/{'plugins/' if self.owner else ''}{self.name}/data"
        pairs = (place.rpartition("/") for place in self.places or (own,))
        return tuple((topic, field) for topic, _, field in pairs)

    @property
    def shape(self) -> str:
        """Shape of the array in a run of K rows and m cables, as in the documentation."""
        return "(K,)" if self.width == 1 else f"(K, {self.width or 'm'})"

    @property
    def sentence(self) -> str:
        """Text, shape, unit and frame in one sentence."""
        units = " and ".join(self.unit.rsplit(", ", 1))
        return ", ".join(filter(None, (self.text, self.shape, units, self.frame))) + "."

    def headings(self, cables: Sequence[str]) -> list[str]:
        """Return the names of its values with units for export; the time is `t`."""
        if self.name == "time":
            return ["t"]
        units = self.unit.split(", ")
        names = self.labels(cables)
        words = [_word(units[i * len(units) // len(names)]) for i in range(len(names))]
        return [f"{name}_{unit}" if unit else name for name, unit in zip(names, words, strict=True)]

    def labels(self, cables: Sequence[str]) -> list[str]:
        """Return the names of its values."""
        if self.width == 1:
            return [self.name]
        numbered = [str(i + 1) for i in range(self.width)]
        parts = cables if self.width == CABLES else _COMPONENTS[self.width] if self.frame else numbered
        return [f"{self.name}_{part}" for part in parts]


def _word(unit: str) -> str:
    """Return a unit as an identifier: m/s^2 is m_per_s2."""
    return unit.replace("/", "_per_").replace("^", "").replace(" ", "")
