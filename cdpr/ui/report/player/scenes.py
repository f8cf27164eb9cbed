"""Scene data of a page: a robot and its frames over time, as the player script expects them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np

from cdpr.log.run import Run
from cdpr.model.robot import Array
from cdpr.scene import Pictures, SensorDrawing, Subject, solid
from cdpr.scene.colours import DARK
from cdpr.scene.shapes import radius_around, world_origin
from cdpr.ui.report.player.arrays import Arrays
from cdpr.ui.report.plots.pictures import frames, pictures_of

UNMARKED: Mapping[str, Any] = MappingProxyType({})
MOST_OUTLINES = 40  # frames with outlines of the cable exits, which turn slowly
VISIBLE = 5e-4  # relative to the diagonal of the scene: deviation of a drawn cable, about half a pixel
FAR = 1.0  # in robot sizes; positions farther away do not enlarge the view


def scene_of_run(run: Run, arrays: Arrays, label: str = "", look: Mapping[str, Any] = UNMARKED) -> dict[str, Any]:
    """Return the scene of a run with at least one row; `look` marks one of several runs."""
    marked = {"thing": look["thing"], "colour": [look["color"], DARK[look["color"]]]} if look else {}
    return scene(pictures_of(run, frames(run)), arrays, label) | marked


def scene(shown: Pictures, arrays: Arrays, label: str = "") -> dict[str, Any]:
    """Return the scene as plain data; long arrays are added to `arrays`."""
    subject = shown.subject
    sane = np.isfinite(np.concatenate([shown.position, shown.orientation], axis=1)).all(axis=1)
    out: dict[str, Any] = {
        "label": label,
        "cables": list(subject.cables),
        "anchors": subject.anchors.tolist(),
        "frame": np.asarray(subject.frame).tolist(),
        "colours": subject.colours,
        "body": _body(subject, arrays),
        "bounds": _bounds(shown, sane),
        "flat": _flat_axis(subject, shown.position[sane]),
        "range": list(shown.range),
        "time": arrays.fine(shown.time),
        "position": arrays.fine(shown.position),
        "orientation": arrays.coarse(shown.orientation),
    }
    if shown.tension is not None and shown.state is not None:
        out["tension"], out["state"] = arrays.coarse(_bounded(shown.tension)), arrays.small(shown.state)
    if shown.desired_position is not None and shown.desired_orientation is not None:
        out["desired"] = [arrays.fine(shown.desired_position), arrays.coarse(shown.desired_orientation)]
    if shown.force is not None:
        size = np.linalg.norm(shown.force, axis=1)
        out["force"] = arrays.coarse(_bounded(shown.force))
        out["strongest"] = float(np.max(size[np.isfinite(size)], initial=0.0))
    if subject.tools:
        out["tools"] = {name: list(point) for name, point in subject.tools.items()}
        out["led"] = subject.led
    if subject.sensors:
        out["sensors"] = [_sensor(each, shown, arrays) for each in subject.sensors]
    if subject.exits:
        out["exits"] = arrays.fine(shown.ends[:, :, 0])
        out["outlines"] = _outlines(shown, arrays)
    low, high = out["bounds"]
    lines = shown.thinned_lines(VISIBLE * float(np.linalg.norm(np.subtract(high, low))))
    if lines.shape[2] > 2:
        out["curves"] = arrays.fine(lines[:, :, 1:-1])
    return out


def _bounded(values: Array) -> Array:
    """Clip outliers of a diverging run, so that the quantisation still resolves all other values."""
    finite = values[np.isfinite(values)]
    if not finite.size:
        return values
    far = 100.0 * max(float(np.percentile(np.abs(finite), 90)), 1e-9)
    return np.clip(values, -far, far)


def _body(subject: Subject, arrays: Arrays) -> dict[str, Any] | None:
    body = solid(subject.shape)
    if body is None:
        return None
    vertices, triangles = arrays.fine(body.vertices), arrays.coarse(body.triangles)
    return {"vertices": vertices, "triangles": triangles, "faces": [list(face) for face in body.faces]}


def _sensor(sensor: SensorDrawing, shown: Pictures, arrays: Arrays) -> dict[str, Any]:
    """Return the drawing of a sensor, and its values in all frames if they are known."""
    parts = {"edges": sensor.edges, "marks": sensor.marks, "rays": sensor.rays}
    values = shown.readings.get(sensor.name)
    return {
        "name": sensor.name,
        "carried": sensor.carried,
        "at": sensor.at.tolist(),
        **{key: part.round(6).tolist() for key, part in parts.items()},
        **({} if values is None else {"values": arrays.coarse(values)}),
    }


def _bounds(shown: Pictures, sane: Any) -> list[list[float]]:
    """Return two opposite corners of a box around the frame, the anchors and the platform's path."""
    subject = shown.subject
    fixed = np.concatenate([subject.anchors[:, :3], np.asarray(subject.frame).reshape(-1, 3)])
    wanted = shown.position[:1] if shown.desired_way is None else shown.desired_way
    known = np.concatenate([fixed, wanted[np.isfinite(wanted).all(axis=1)]])  # a single anchor has no extent
    middle, size = known.mean(axis=0), float(np.linalg.norm(np.ptp(known, axis=0))) or 1.0
    way = np.concatenate([shown.position[sane], shown.way[sane]]) if subject.led else shown.position[sane]
    way = way[np.linalg.norm(way - middle, axis=1) < FAR * size]
    around = radius_around(subject.shape, subject.anchors[:, 3:])
    points = np.concatenate([fixed, way.reshape(-1, 3), world_origin(fixed)])
    if len(fixed) < 3 or not len(subject.frame):
        points = np.concatenate([points, way - around, way + around])
    return [points.min(axis=0).tolist(), points.max(axis=0).tolist()]


def _flat_axis(subject: Subject, way: Array) -> int | None:
    """Return the axis along which frame, anchors and path have no extent; a planar robot is viewed along it."""
    fixed = (subject.anchors[:, :3], np.asarray(subject.frame).reshape(-1, 3), way)
    extent = np.ptp(np.concatenate(fixed), axis=0)
    flat = np.flatnonzero(extent < 1e-6 * max(float(extent.max()), 1e-9))
    return int(flat[0]) if len(flat) == 1 else None


def _outlines(shown: Pictures, arrays: Arrays) -> dict[str, Any]:
    """Return the outlines of the cable exits in some of the frames."""
    rows = np.unique(np.rint(np.linspace(0, len(shown.time) - 1, MOST_OUTLINES)).astype(int))
    drawn = [shown.subject.exit_lines(shown.ends[k]) for k in rows]
    sizes: Sequence[int] = [len(line) for line in drawn[0]]
    points = np.concatenate([line for lines in drawn for line in lines]) if sizes else np.empty((0, 3))
    return {"rows": rows.tolist(), "sizes": list(sizes), "points": arrays.coarse(points)}
