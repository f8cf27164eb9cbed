"""True values of the quantities that sensors measure, from the rows of a run; and the errors of the measurements."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from cdpr.log.run import Run
from cdpr.model import rotations
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.scene.sensors import principal_point, ray_directions

LEAST = 1e-6  # relative: a period or an age nearer to a whole number of rows is one


def rows_before(run: Run, sensor: Mapping[str, Any]) -> int:
    """Return the number of rows before each row on which the true values of a sensor depend."""
    return max(1, round(_period(run, sensor) / run.header.log_step))


def _period(run: Run, sensor: Mapping[str, Any]) -> float:
    return float(sensor["period"] or run.header.control_step)


def truth(run: Run, sensor: Mapping[str, Any], key: str) -> Array | None:
    """Return the true values of a quantity at the rows of a run (K, w); None if the log does not determine them.

    The first rows miss those before them, `rows_before`, unless they are those of the whole run.
    """
    match sensor["type"], key:
        case ("pose", "position"):
            return run.position
        case ("pose", "attitude"):
            return run.orientation
        case ("twist", "velocity"):
            return run.velocity
        case ("twist", "turn_rate"):
            return run.angular_velocity
        case ("encoders", "length" | "rate"):
            return _unwound(run, key)
        case ("tension", "tension"):
            return _tensions(run, sensor)
        case ("imu", "turn_rate"):
            return rotations.rotate(rotations.conjugate(run.orientation), run.angular_velocity)
        case ("imu", "force"):
            return _specific_force(run, sensor)
        case ("receiver", "position"):
            return run.position + rotations.rotate(run.orientation, np.array(sensor["antenna"]))
        case ("range" | "scan", "distance"):
            return _distances(run, sensor)
        case ("markers", "pixel"):
            return _pixels(run, sensor)
    return None


def _unwound(run: Run, key: str) -> Array | None:
    """Return unwound lengths or their rates; they are the lengths of the cables if no cable has a winch."""
    known = run.header.layout.fields
    if run.header.ideal_cables:
        return run[key]
    name = f"unstretched_{key}"
    return run[name] if name in known else None


def _tensions(run: Run, sensor: Mapping[str, Any]) -> Array | None:
    """Return the tensions of the control period before each row."""
    head = run.header
    if head.log_every > 1:
        return None  # that period is not in the log
    behind = sensor.get("at") == "winch" and "winch_tension" in head.layout.fields
    tensions = run["winch_tension"] if behind else run.cable_tension
    return np.concatenate([np.zeros_like(tensions[:1]), tensions[:-1]])


def _specific_force(run: Run, sensor: Mapping[str, Any]) -> Array | None:
    """Return (v(t) - v(t - h)) / h - g in platform axes, of the point of an IMU with the period h; -g at first."""
    steps, period = _period(run, sensor) / run.header.log_step, _period(run, sensor)
    if abs(steps - round(steps)) > LEAST * steps:
        return None
    n, arm = max(1, round(steps)), rotations.rotate(run.orientation, np.array(sensor["point"], dtype=float))
    velocity = run.velocity + rotations.cross(run.angular_velocity, arm)
    gained = np.zeros_like(velocity)
    gained[n:] = (velocity[n:] - velocity[:-n]) / period
    return rotations.rotate(rotations.conjugate(run.orientation), gained - np.array(run.header.gravity))


def _distances(run: Run, sensor: Mapping[str, Any]) -> Array | None:
    if "solids" not in sensor:
        return None
    rays = ray_directions(sensor)
    state, found = np.zeros(13), np.zeros(len(rays))
    cast = bind(
        "cast_rays",
        state=state,
        point=np.array(sensor["point"], dtype=float),
        solids=np.array(sensor["solids"], dtype=float).reshape(len(sensor["solids"]), -1),
        directions=rays,
        distances=found,
        reach=float(sensor["reach"]),
    )
    poses, out = np.concatenate([run.position, run.orientation], axis=1), np.empty((len(run.rows), len(rays)))
    for pose, distances in zip(poses, out, strict=True):
        state[:7] = pose
        cast()
        distances[:] = found
    return out


def _pixels(run: Run, sensor: Mapping[str, Any]) -> Array:
    """Return the pixels of all markers, as if none were hidden."""
    marks, attitude = np.array(sensor["markers"], dtype=float), np.array(sensor["attitude"], dtype=float)
    place, camera = np.array(sensor["position"], dtype=float), rotations.matrix(attitude / np.linalg.norm(attitude))
    R, p = rotations.matrix(run.orientation), run.position[:, None]
    if sensor["on"] == "platform":
        seen = np.einsum("nji,nkj->nki", R, marks - p)
    else:
        seen = p + np.einsum("nij,kj->nki", R, marks)
    x, y, z = np.moveaxis(np.einsum("ji,nkj->nki", camera, seen - place), -1, 0)
    (fx, fy), (cx, cy) = sensor["focal"], principal_point(sensor)
    return np.stack([fx * x / z + cx, fy * y / z + cy], axis=-1).reshape(len(run.rows), -1)


def measured_truth(run: Run, sensor: Mapping[str, Any], key: str) -> Array | None:
    """Return the true values (K, w) at the time of the measurement that is held at each row, by interpolation."""
    values = truth(run, sensor, key)
    if values is None:
        return None
    back = run[f"{sensor['name']}_age"] / run.header.log_step
    place = np.clip(np.arange(len(back)) - np.nan_to_num(back), 0.0, len(back) - 1.0)
    near = np.rint(place)
    place = np.where(np.abs(place - near) < LEAST * (1.0 + back), near, place)
    low = np.floor(place).astype(np.int64)
    share, high = (place - low)[:, None], np.minimum(low + 1, len(back) - 1)
    return np.where(share > 0.0, (1.0 - share) * values[low] + share * values[high], values[low])


def errors(run: Run, sensor: Mapping[str, Any], key: str) -> Array | None:
    """Return measured minus true values (K, w), of an attitude as rotation vectors (K, 3), rad, platform axes.

    Of markers, only those which the camera sees have an error; others have NaN.
    """
    values = measured_truth(run, sensor, key)
    if values is None:
        return None
    measured = run[f"{sensor['name']}_{key}"].reshape(len(values), -1)
    if key == "attitude":
        sizes = np.linalg.norm(values, axis=1, keepdims=True)
        world = rotations.between(values / sizes, measured)
        return rotations.rotate(rotations.conjugate(values / sizes), world)
    if sensor["type"] == "markers":
        seen = run[f"{sensor['name']}_seen"].reshape(len(values), -1) > 0.5
        return np.where(np.repeat(seen, 2, axis=1), measured - values, np.nan)
    return measured - values
