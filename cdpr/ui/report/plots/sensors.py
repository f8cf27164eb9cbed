"""Time histories of sensors and of the estimated state, against the truth, with the bands that their noise explains."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from cdpr.base.column import CABLES as ALL_CABLES
from cdpr.base.column import Column
from cdpr.base.columns import GROUPS
from cdpr.log.consistency import band, estimate_errors
from cdpr.log.run import Run
from cdpr.log.summary import PIECE
from cdpr.model import rotations
from cdpr.model.robot import Array
from cdpr.sensing import Sensor
from cdpr.sensing.sensor import Quantity
from cdpr.ui.report.plots.decimate import BINS, Extrema
from cdpr.ui.report.plots.histories import Points
from cdpr.ui.report.plots.panel import Curves, Entry, Limit, Panel
from cdpr.ui.report.plots.truths import errors, measured_truth, rows_before
from cdpr.ui.report.style import AXES, DARK, DESIRED, INK, SOFT, cable_looks, shorten, typeset, with_unit

SIGMAS = 3.0  # half width of a band; 99.7 % of normal errors are within it
MOST_CURVES = 16  # beyond, only the mean over the values and the root of the mean square of their errors
ESTIMATES = ("estimated", "uncertainty", "innovation")  # groups of columns
ERROR_LABELS = ("position", "attitude", "velocity", "angular velocity")
ERROR_UNITS = ("m", "rad", "m/s", "rad/s")


def names_of(run: Run) -> frozenset[str]:
    """Return the names of the columns that the panels of sensors and of the estimate show."""
    own = {column.name for group in ESTIMATES if run.header.layout.has(group) for column in GROUPS[group].columns}
    for sensor in run.header.sensor_objects:
        own |= {column.name for column in _columns(run, sensor).values()}
    return frozenset(own)


def _columns(run: Run, sensor: Sensor) -> dict[str, Column]:
    """Return the columns of a sensor by the keys of its quantities, and "age"."""
    fields = run.header.layout.fields
    named = {each.name.removeprefix(f"{sensor.title}_"): each.name for each in sensor.columns}
    return {key: fields[name] for key, name in named.items() if name in fields}


def sensors(run: Run) -> list[Panel]:
    """Return the panels of all sensors: each quantity, measured and true, its error, and the age."""
    panels: list[Panel] = []
    for sensor in run.header.sensor_objects:
        columns = _columns(run, sensor)
        for each in sensor.quantities:
            panels += _quantity(run, sensor, each, columns[each.key])
        if sensor.quantities and _loses(run, sensor):
            panels.append(_plain(run, columns["age"]))
    return panels


def _loses(run: Run, sensor: Sensor) -> bool:
    """Return True if a measurement of a sensor was late or lost, so that its age shows more than its period."""
    usual = sensor.delay + max(sensor.period, run.header.log_step)
    return bool(_oldest(run, sensor) > usual + 0.5 * run.header.log_step)


def _quantity(run: Run, sensor: Sensor, quantity: Quantity, column: Column) -> list[Panel]:
    """Return the panel of measured and true values, and that of their difference if the truth is known."""
    key, lag = quantity.key, _lag(run, sensor)
    name = column.name
    wide = column.width > MOST_CURVES
    measured = _history(run, lambda part: _reduced(part[name], wide))
    if errors(run.part(0, 1), sensor, key) is None:
        return [_plain(run, column)]
    true = _history(run, lambda part: _reduced(measured_truth(part, sensor, key), wide), lag)
    looks = _looks(run, column, wide)
    names = [label for label, _ in looks]
    cable = "cable" if column.width == ALL_CABLES else ""
    lines = (
        Curves(measured, [look["color"] for _, look in looks], ("-",), 1.4, names, cable),
        Curves(true, [INK] if wide else _dark(column), (DESIRED,), 0.9, [f"{each} true" for each in names], "over"),
    )
    how: list[Entry] = [
        ("measured", {"color": SOFT, "linewidth": 1.4}),
        ("true", {"color": INK, "linewidth": 0.9, "linestyle": DESIRED}),
    ]
    label = with_unit(f"{'mean ' if wide else ''}{shorten(name)}", column.unit)
    both = Panel(label, lines, [*looks, *how], name=name)
    return [both, _error(run, sensor, quantity, column, lag)]


def _error(run: Run, sensor: Sensor, quantity: Quantity, column: Column, lag: int) -> Panel:
    wide, attitude = column.width > MOST_CURVES, quantity.attitude
    unit = "rad" if attitude else column.unit

    def found(part: Run) -> Array:
        each = errors(part, sensor, quantity.key)
        assert each is not None
        if not wide:
            return each
        counted = np.maximum(np.isfinite(each).sum(axis=1, keepdims=True), 1)
        return np.asarray(np.sqrt(np.nansum(each**2, axis=1, keepdims=True) / counted))

    points = _history(run, found, lag)
    looks = [(axis, {"color": colour}) for axis, colour in zip("xyz", AXES, strict=True)] if attitude else []
    looks = looks or _looks(run, column, wide)
    sigma = sensor.errors_of(quantity).noise
    limits = (
        (Limit(f"3 σ of the noise: {SIGMAS * sigma:.3g} {typeset(unit)}", _ends(sigma, wide)),) if sigma > 0.0 else ()
    )
    lines = Curves(points, [look["color"] for _, look in looks], names=[label for label, _ in looks])
    label = with_unit(f"{'rms ' if wide else ''}error of {shorten(column.name)}", unit)
    legend = looks if len(looks) > 1 else ()
    return Panel(label, (lines,), legend, 2.0 * SIGMAS * sigma, limits, name=f"{column.name}_error")


def _ends(sigma: float, wide: bool) -> tuple[float, ...]:
    return (SIGMAS * sigma,) if wide else (-SIGMAS * sigma, SIGMAS * sigma)


def _plain(run: Run, column: Column) -> Panel:
    """Return the panel of a column alone; of many values, their mean."""
    wide = column.width > MOST_CURVES
    points = _history(run, lambda part: _reduced(part[column.name], wide))
    looks = _looks(run, column, wide)
    lines = Curves(points, [look["color"] for _, look in looks], names=[label for label, _ in looks])
    label = with_unit(f"{'mean ' if wide else ''}{shorten(column.name)}", column.unit)
    return Panel(label, (lines,), looks if len(looks) > 1 else (), name=column.name)


def _reduced(values: Array | None, wide: bool) -> Array:
    assert values is not None
    values = values.reshape(len(values), -1)
    return values.mean(axis=1, keepdims=True) if wide else values


def _looks(run: Run, column: Column, wide: bool) -> list[Entry]:
    if wide or column.width == 1:
        return [(column.name, {"color": INK})]
    if column.frame and column.width == 3:
        return [(axis, {"color": colour}) for axis, colour in zip("xyz", AXES, strict=True)]
    labels = run.header.cables if column.width == ALL_CABLES else _short(column)
    return [(shorten(label), look) for label, look in zip(labels, cable_looks(labels), strict=True)]


def _short(column: Column) -> list[str]:
    """Return the names of the values of a column without its own name."""
    return [label.removeprefix(f"{column.name}_") for label in column.labels(())]


def _dark(column: Column) -> Sequence[str]:
    return DARK if column.frame and column.width == 3 else (INK,)


def _lag(run: Run, sensor: Sensor) -> int:
    """Return the number of rows before each part of a long run from which its measurements may be."""
    return int(np.ceil(_oldest(run, sensor) / run.header.log_step)) + 1 + rows_before(run, sensor)


def _oldest(run: Run, sensor: Sensor) -> float:
    """Return the largest age of a measurement, s."""
    return max(float(np.nanmax(part[f"{sensor.title}_age"], initial=0.0)) for part, _, _ in _parts(run, 0))


def _parts(run: Run, lag: int) -> Sequence[tuple[Run, int, int]]:
    """Return parts of a run, of whole bins, each with `lag` rows before it if there are any: first and last row."""
    count = len(run.rows)
    bins = -(-count // BINS) or 1
    size = max(count, 1) if isinstance(run.rows, np.ndarray) else bins * -(-PIECE // bins)
    starts = range(0, count, size)
    return [(run.part(max(i - lag, 0), min(i + size, count)), i - max(i - lag, 0), i) for i in starts]


def _history(run: Run, values: Callable[[Run], Array], lag: int = 0) -> Points:
    """Return the samples to plot of a quantity."""
    bins = Extrema(len(run.rows))
    with np.errstate(all="ignore"):  # a diverged run ends in inf and NaN
        for part, before, _ in _parts(run, lag):
            bins.add(part.time[before:], values(part)[before:])
    return Points(*bins.result())


def estimate(run: Run) -> list[Panel]:
    """Return the panels of the estimate: pose, true and estimated; errors with the 3-sigma band; NIS and NEES."""
    layout = run.header.layout
    if not layout.has("estimated"):
        return []
    panels = [_true_and_estimated(run, name) for name in ("position", "velocity", "angular_velocity")]
    panels.insert(1, _attitudes(run))
    sigma = layout.has("uncertainty")
    panels += [_estimate_error(run, i, label, banded=sigma) for i, label in enumerate(ERROR_LABELS)]
    if layout.has("innovation"):
        panels.append(_consistency(run, "nis", lambda part: part["nis_size"]))
    if sigma:
        panels.append(_consistency(run, "nees", lambda part: np.count_nonzero(part["estimate_sigma"] > 0.0, axis=1)))
    return panels


def _true_and_estimated(run: Run, name: str) -> Panel:
    unit = run.header.layout.fields[name].unit
    own = _history(run, lambda part: part[f"estimated_{name}"]), _history(run, lambda part: part[name])
    return _pair(with_unit(name.replace("_", " "), unit), f"estimated_{name}", *own)


def _attitudes(run: Run) -> Panel:
    """Return the rotation vectors from the first true attitude to the true and to the estimated one."""
    start = run.part(0, 1).orientation

    def turned(name: str) -> Callable[[Run], Array]:
        return lambda part: rotations.between(np.broadcast_to(start, part[name].shape), part[name])

    own = _history(run, turned("estimated_orientation")), _history(run, turned("orientation"))
    return _pair("rotation from the start (rad)", "estimated_orientation", *own)


def _pair(label: str, name: str, estimated: Points, true: Points) -> Panel:
    lines = (
        Curves(estimated, AXES, width=1.6, names="xyz", group="axis"),
        Curves(true, DARK, (DESIRED,), 0.9, [f"{axis} true" for axis in "xyz"], "over"),
    )
    legend: list[Entry] = [(axis, {"color": colour}) for axis, colour in zip("xyz", AXES, strict=True)]
    legend += [
        ("estimated", {"color": SOFT, "linewidth": 1.6}),
        ("true", {"color": INK, "linewidth": 0.9, "linestyle": DESIRED}),
    ]
    return Panel(label, lines, legend, 1e-3, name=name)


def _estimate_error(run: Run, which: int, label: str, *, banded: bool) -> Panel:
    """Return the panel of one error of the estimate, with plus and minus three standard deviations if known."""
    lines = [Curves(_history(run, lambda part: estimate_errors(part)[which]), AXES, names="xyz", group="axis")]
    legend: list[Entry] = [(axis, {"color": colour}) for axis, colour in zip("xyz", AXES, strict=True)]
    if banded:
        of = slice(3 * which, 3 * which + 3)
        for sign in (SIGMAS, -SIGMAS):
            ends = _history(run, lambda part, by=sign: by * part["estimate_sigma"][:, of])  # type: ignore[misc]
            lines.append(Curves(ends, DARK, (DESIRED,), 0.9, [f"±{SIGMAS:.0f} σ"] * 3, "band"))
        legend.append(("±3 σ of the estimator", {"color": INK, "linewidth": 0.9, "linestyle": DESIRED}))
    text = f"error of {label} ({ERROR_UNITS[which]})"
    return Panel(text, tuple(lines), legend, name=f"estimate_error_{label.replace(' ', '_')}")


def _consistency(run: Run, name: str, sizes: Callable[[Run], Array]) -> Panel:
    """Return the panel of a normalised square per value, with the ends of the 95 % band of its usual size."""
    counts: dict[int, int] = {}
    for part, _, _ in _parts(run, 0):
        with np.errstate(all="ignore"):
            found, many = np.unique(np.nan_to_num(sizes(part)).astype(int), return_counts=True)
        for size, count in zip(found.tolist(), many.tolist(), strict=True):
            counts[size] = counts.get(size, 0) + count
    counts.pop(0, None)
    limits: tuple[Limit, ...] = ()
    if counts:
        usual = max(counts, key=lambda size: counts[size])
        limits = (Limit(f"95 % band of {usual} values", band(usual)),)
    values = Curves(_history(run, lambda part: part[name].reshape(-1, 1)), (INK,), names=(name,))
    return Panel(name.upper(), (values,), limits=limits, name=name)
