"""Drawings of sensors: frustums of cameras, rays to measured distances, and points of other sensors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from cdpr.model import rotations
from cdpr.model.robot import Array, frozen_array

MOST_RAYS = 61  # of a scan that are drawn
DEPTH = 0.1  # of a frustum, relative to the extent of the frame anchors
NONE = frozen_array(np.empty((0, 3)))
POINTS = {"imu": "point", "receiver": "antenna", "range": "point", "scan": "point"}


@dataclass(frozen=True, eq=False)
class SensorDrawing:
    """Drawing of a sensor: what is fixed, in the axes of the body that carries it, and the column that it reads."""

    name: str
    carried: bool  # True if the platform carries it, else the world
    at: Array  # (3,), m
    edges: Array = field(default_factory=lambda: NONE)  # (2 k, 3), m: pairs of ends, such as the edges of a frustum
    marks: Array = field(default_factory=lambda: NONE)  # (k, 3), m: points of the other body that it sees
    rays: Array = field(default_factory=lambda: NONE)  # (k, 3), unit vectors from `at`
    column: str = ""  # distances along the rays, or 1 for each mark that it sees
    chosen: tuple[int, ...] = ()  # the values of this column that are drawn

    def read(self, rows: Array) -> Array:
        """Return the values to draw (n, k) of the rows (n, w) of its column."""
        return np.asarray(rows.reshape(len(rows), -1)[:, self.chosen])

    def tips(self, position: Array, orientation: Array, distances: Array) -> Array:
        """Return the ends (n, k, 3), m, world axes, of its rays at poses (n, 3) and (n, 4) with distances (n, k)."""
        local = self.at + distances[..., None] * self.rays
        return np.asarray(position[:, None] + np.einsum("nij,nkj->nki", rotations.matrix(orientation), local))


def sensor_drawings(sensors: Sequence[Mapping[str, Any]], extent: float) -> tuple[SensorDrawing, ...]:
    """Return the drawings of all sensors with a place.

    Args:
        sensors: sections of the sensors with their names, as in the header of a log.
        extent: size of the robot, m.
    """
    drawn = (_drawing(each, DEPTH * extent) for each in sensors)
    return tuple(each for each in drawn if each is not None)


def _drawing(sensor: Mapping[str, Any], depth: float) -> SensorDrawing | None:
    name, kind = str(sensor["name"]), sensor["type"]
    if "focal" in sensor and "size" in sensor:  # a pinhole camera
        at, marks = np.array(sensor["position"], dtype=float), np.array(sensor.get("markers") or NONE, dtype=float)
        column = f"{name}_seen" if len(marks) else ""
        carried = sensor.get("on", "platform") == "platform"
        chosen = tuple(range(len(marks)))
        return SensorDrawing(name, carried, at, frustum(sensor, depth), marks, column=column, chosen=chosen)
    if kind not in POINTS:
        return None
    at = np.array(sensor[POINTS[kind]], dtype=float)
    rays = ray_directions(sensor)
    if not len(rays):
        return SensorDrawing(name, True, at)
    few = np.unique(np.rint(np.linspace(0, len(rays) - 1, min(len(rays), MOST_RAYS))).astype(int))
    return SensorDrawing(name, True, at, rays=rays[few], column=f"{name}_distance", chosen=tuple(few.tolist()))


def ray_directions(sensor: Mapping[str, Any]) -> Array:
    """Return the unit vectors (k, 3), platform axes, along which a sensor measures distances; none for other types."""
    if sensor["type"] == "range":
        direction = np.array([sensor["direction"]], dtype=float)
        return np.asarray(direction / np.linalg.norm(direction))
    if sensor["type"] == "scan":
        angles = np.linspace(sensor["first"], sensor["last"], sensor["rays"])
        return np.column_stack([np.cos(angles), np.sin(angles), np.zeros(len(angles))])
    return NONE


def principal_point(sensor: Mapping[str, Any]) -> tuple[float, float]:
    """Return the principal point of a camera, px; by default the middle of its image."""
    width, height = sensor["size"]
    cx, cy = sensor.get("center") or (0.5 * width, 0.5 * height)
    return float(cx), float(cy)


def frustum(sensor: Mapping[str, Any], depth: float) -> Array:
    """Return the edges (16, 3), m, of the pyramid that a camera sees up to a depth, m, in the axes of its body."""
    (fx, fy), (width, height), (cx, cy) = sensor["focal"], sensor["size"], principal_point(sensor)
    pixels = np.array([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]])
    corners = depth * np.column_stack([(pixels - [cx, cy]) / [fx, fy], np.ones(4)])
    edges = [end for i in range(4) for end in (np.zeros(3), corners[i], corners[i], corners[(i + 1) % 4])]
    attitude = np.array(sensor["attitude"], dtype=float)
    R = rotations.matrix(attitude / np.linalg.norm(attitude))
    return np.asarray(sensor["position"] + np.einsum("ij,kj->ki", R, np.array(edges)))
