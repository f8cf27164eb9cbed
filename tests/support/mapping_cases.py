"""FMU descriptions and their signals mapped to those of a robot."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import crossed_box, make_robot
from fmu_cases import PLANT, description, signals

from cdpr.base.errors import FmuError
from cdpr.fmu.read.description import read_description
from cdpr.fmu.read.mapping import map_signals
from cdpr.fmu.read.options import Signals

ROBOT = make_robot(crossed_box(np.random.default_rng(1), 8))


def about(fmi=3, rows=None, **options):
    return read_description(description(fmi, rows, **options).encode())


def plant(fmi=3, without=(), more=(), **units):
    """A plant, some signals left out or in other units, and further variables."""
    table = {name: (side, size, units.get(name, unit)) for name, (side, size, unit) in PLANT.items()}
    return about(fmi, [*signals(fmi, {name: row for name, row in table.items() if name not in without}), *more])


def names(port):
    return [element.name for element in port.elements]


def refused(fmu, *words, robot=ROBOT, role="plant", **given):
    with pytest.raises(FmuError) as caught:
        map_signals(fmu, robot, Signals(**given), role)
    for word in words:
        assert word in str(caught.value)
    return str(caught.value)


def read(port, side, values):
    out = np.full(4 if port.euler else len(port.elements), np.nan)
    flat = np.zeros(side.size)
    place = {}
    at = 0
    for each in side.variables:
        place[each.name] = at
        at += each.size
    for name, value in values.items():
        flat[place[name] : place[name] + np.size(value)] = value
    port.read(flat, out)
    return out
