"""However the author of an FMU named, ordered and scaled its variables: mapped, the signals are the same."""

from __future__ import annotations

import numpy as np
from conftest import crossed_box, make_robot
from fmu_cases import PLANT, description, variable
from hypothesis import given
from hypothesis import strategies as st

from cdpr.fmu.read.description import read_description
from cdpr.fmu.read.mapping import map_signals
from cdpr.fmu.read.options import Signals, Source

ROBOT = make_robot(crossed_box(np.random.default_rng(1), 8))
# Factor by unit, of those that an author may choose.
UNITS = {"N": {"N": 1.0, "kN": 1000.0}, "m": {"m": 1.0, "mm": 0.001}, "rad/s": {"rad/s": 1.0, None: 1.0}}
CABLES = ("cable_tension", "cable_length")


class Author:
    """An FMU with the signals of a plant, made by somebody else; and the scenario's word for it."""

    def __init__(self, data):
        rng = np.random.default_rng(data.draw(st.integers(0, 2**32)))
        self.fmi = data.draw(st.sampled_from([2, 3]))
        self.rows, self.said, self.places = [], {"input": {}, "output": {}}, {}
        cable_order = rng.permutation(8)  # the FMU's number of each cable
        references = iter(rng.permutation(1000).tolist())
        for number, (name, (side, size, unit)) in enumerate(PLANT.items()):
            declared = data.draw(st.sampled_from([*UNITS.get(unit, {unit: 1.0})]))
            factor = UNITS.get(unit, {unit: 1.0})[declared]
            sign = data.draw(st.sampled_from([1.0, -1.0]))
            order = cable_order if name in CABLES else rng.permutation(size)
            base = f"{data.draw(st.sampled_from('abcxyz'))}{number}"
            array = self.fmi == 3 and data.draw(st.booleans())
            if array:
                reference = next(references)
                self.rows.append(variable(3, base, reference, side, shape=(size,), unit=declared))
                names = [f"{base}[{i + 1}]" for i in range(size)]
                keys = [(reference, i) for i in range(size)]
            else:
                names = [f"{base}.{i}" for i in rng.permutation(50)[:size]]
                keys = [(next(references), 0) for _ in names]
                self.rows += [
                    variable(self.fmi, each, key[0], side, unit=declared) for each, key in zip(names, keys, strict=True)
                ]
            self.places[name] = [(keys[i], sign / factor) for i in order]  # FMU value = SI * sign / factor
            self.said[side][name] = Source(variable=tuple(names[i] for i in order), factor=sign)
        rng.shuffle(self.rows)

    def mapping(self):
        fmu = read_description(description(self.fmi, self.rows).encode())
        return map_signals(fmu, ROBOT, Signals(inputs=self.said["input"], outputs=self.said["output"]))


def flat_places(side):
    """Return the place of element i of the variable with a reference among all values."""
    places, at = {}, 0
    for each in side.variables:
        for i in range(each.size):
            places[each.value_reference, i] = at + i
        at += each.size
    return places


@given(st.data())
def test_names_order_units_and_layout_do_not_matter(data):
    author = Author(data)
    mapping = author.mapping()
    rng = np.random.default_rng(0)
    for side in (mapping.inputs, mapping.outputs):
        flat = flat_places(side)
        values = np.zeros(side.size)
        for name, port in side.ports.items():
            signal = rng.normal(size=len(author.places[name]))
            expected = [value * scale for value, (_, scale) in zip(signal, author.places[name], strict=True)]
            port.write(signal, values)
            assert np.allclose([values[flat[key]] for key, _ in author.places[name]], expected, rtol=1e-14, atol=0)
            back = np.empty(len(signal))
            port.read(values, back)
            assert np.allclose(back, signal, rtol=1e-14, atol=0)
    assert mapping.inputs.size == 14
    assert mapping.outputs.size == 21
