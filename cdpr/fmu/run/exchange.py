"""Signals between the arrays of cdpr and the values of an FMU, all signals of an array in one compiled call."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from cdpr.base import tolerances
from cdpr.fmu.read.ports import Port, Side
from cdpr.model.robot import Array
from cdpr.native.bind import bind

NEARLY = 2.0 * tolerances.UNIT  # of the square of a quaternion's length

# Positions of the signals in the state and the desired state of a platform, in the layout of `cdpr.model`.
STATE = {"position": 0, "quaternion": 3, "velocity": 7, "angular_velocity": 10}
DESIRED = {
    **{f"desired_{name}": place for name, place in STATE.items()},
    "desired_acceleration": 13,
    "desired_angular_acceleration": 16,
}


def reader(side: Side, layout: Mapping[str, int], values: Array, out: Array) -> Callable[[], object]:
    """Return a function that writes the available signals of `layout`, given by name and position, into `out`."""
    plain, angles = _ports(side, layout)
    views = [(port, out[layout[port.signal] : layout[port.signal] + 4]) for port in angles]
    fast = bind("gather_signals", **_joined(plain, layout), values=values, signals=out)
    if not views:
        return fast

    def read() -> None:
        fast()
        for port, view in views:
            port.read(values, view)

    return read


def writer(side: Side, layout: Mapping[str, int], values: Array) -> Callable[[Array], None]:
    """Return a function that writes the signals of `layout` from an array into the FMU's values."""
    plain, angles = _ports(side, layout)
    joined = _joined(plain, layout)
    taken = np.zeros(int(joined["place"].max(initial=-1)) + 1)
    fast = bind("scatter_signals", **joined, signals=taken, values=values)
    spans = [(port, slice(layout[port.signal], layout[port.signal] + 4)) for port in angles]

    def write(signals: Array) -> None:
        taken[:] = signals[: len(taken)]
        fast()
        for port, span in spans:
            port.write(signals[span], values)

    return write


def normaliser(state: Array) -> Callable[[], object]:
    """Return the operation that normalises the quaternion of `state` (13,) if its length is near 1."""
    return bind("normalise_attitude", state=state, near=NEARLY)


def _ports(side: Side, layout: Mapping[str, int]) -> tuple[list[Port], list[Port]]:
    found = [side.ports[name] for name in layout if name in side.ports]
    return [port for port in found if not port.euler], [port for port in found if port.euler]


def _joined(ports: list[Port], layout: Mapping[str, int]) -> dict[str, Any]:
    places = [np.arange(len(port.index)) + layout[port.signal] for port in ports]
    columns = [port.index for port in ports], [port.scale for port in ports], [port.offset for port in ports]
    index, scale, offset = (np.concatenate([[], *column]) for column in columns)
    place = np.concatenate([[], *places]).astype(np.int64)
    return {"place": place, "index": index.astype(np.int64), "scale": scale, "offset": offset}
