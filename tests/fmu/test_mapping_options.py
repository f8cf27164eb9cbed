"""Signals of an FMU named by the scenario: orders, units and signs."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import crossed_box, make_robot
from fmu_cases import variable
from mapping_cases import ROBOT, about, names, plant, read, refused

from cdpr.fmu.read.mapping import map_signals, resolve
from cdpr.fmu.read.options import Signals, Source
from cdpr.model import rotations

EXPLICIT = [
    ("Fc[{i}]", ["Fc[1]", "Fc[2]"]),
    ("Fc[{i0}]", None),
    ("Fc", ["Fc[1]", "Fc[2]"]),
    (("Fc[2]", "g"), ["Fc[2]", "g"]),
    (("g", "A[2,1]"), ["g", "A[2,1]"]),
    (("g",), None),
    (("g", "g"), None),
    (("g", "A"), None),
    (("g", "missing"), None),
    (("g", "flag"), None),
    (("g", "result"), None),
    ("none", None),
]


@pytest.mark.parametrize(("given", "expected"), EXPLICIT, ids=str)
def test_files_named_by_the_scenario(given, expected):
    rows = [
        variable(3, "Fc[1]", 1, "input"), variable(3, "Fc[2]", 2, "input"), variable(3, "g", 3, "input"),
        variable(3, "A", 4, "input", shape=(2, 2)), variable(3, "flag", 5, "input", kind="Boolean", start="true"),
        variable(3, "result", 6, "output"),
    ]  # fmt: skip
    two = make_robot(crossed_box(np.random.default_rng(1), 2))
    mapping, problems = resolve(about(3, rows), two, Signals(inputs={"cable_tension": given}), "plant")
    if expected is None:
        assert any("cable_tension" in problem for problem in problems)
    else:
        assert names(mapping.inputs.ports["cable_tension"]) == expected


def test_part_of_an_array_leaves_the_rest_at_its_start():
    rows = [variable(3, "A", 4, "input", shape=(4,), start="1 2 3 4")]
    two = make_robot(crossed_box(np.random.default_rng(1), 2))
    mapping, _ = resolve(about(3, rows), two, Signals(inputs={"cable_tension": ("A[4]", "A[1]")}), "plant")
    values = mapping.inputs.start()
    mapping.inputs.ports["cable_tension"].write(np.array([40.0, 10.0]), values)
    assert values.tolist() == [10.0, 2.0, 3.0, 40.0]


def test_outputs_may_be_local_if_the_scenario_assigns_them():
    rows = [variable(3, "r", 50, "local", shape=(3,), unit="m")]
    mapping = map_signals(plant(without=["position"], more=rows), ROBOT, Signals(outputs={"position": "r"}))
    assert names(mapping.outputs.ports["position"])[0] == "r[1]"


def test_one_number_is_not_two_signals():
    refused(
        plant(),
        "'position[1]' is already used for position",
        outputs={"velocity": Source(variable="position", unit="m/s")},
    )
    rows = [variable(2, f"other[{i}]", i, "input") for i in range(1, 9)]  # aliases of cable_tension
    refused(plant(2, more=rows), "already used", inputs={"command": "other[{i}]"})


def test_cable_order():
    order = (3, 1, 2, 8, 7, 6, 5, 4)
    mapping = map_signals(plant(), ROBOT, Signals(cable_order=order))
    values = mapping.inputs.start()
    mapping.inputs.ports["cable_tension"].write(np.arange(1.0, 9.0), values)
    assert [values[number - 1] for number in order] == list(range(1, 9))
    length = read(mapping.outputs.ports["cable_length"], mapping.outputs, {"cable_length": np.arange(1.0, 9.0)})
    assert length.tolist() == list(order)
    assert names(mapping.outputs.ports["position"]) == ["position[1]", "position[2]", "position[3]"]
    for wrong in ((1, 2), (0, 1, 2, 3, 4, 5, 6, 7), (1, 1, 2, 3, 4, 5, 6, 7)):
        refused(plant(), "cable_order: expected the numbers from 1 to 8", cable_order=wrong)


def test_quaternion_order():
    mapping = map_signals(plant(), ROBOT, Signals(outputs={"quaternion": Source(variable="quaternion", order="xyzw")}))
    q = read(mapping.outputs.ports["quaternion"], mapping.outputs, {"quaternion": [0.1, 0.2, 0.3, 0.9]})
    assert q.tolist() == [0.9, 0.1, 0.2, 0.3]
    refused(plant(), "wxyz or xyzw, got 'wzyx'", outputs={"quaternion": Source(variable="quaternion", order="wzyx")})
    refused(plant(), "only quaternions have an order", outputs={"position": Source(variable="position", order="xyzw")})


@pytest.mark.parametrize("order", ["XYZ", "xyz", "ZXZ", "zyx"])
def test_euler_angles_in_degrees(order):
    rows = [variable(3, name, 50 + i, "output", unit="deg") for i, name in enumerate(["phi", "theta", "psi"])]
    given = {"euler": Source(variable=("phi", "theta", "psi"), order=order)}
    mapping = map_signals(plant(without=["quaternion"], more=rows), ROBOT, Signals(outputs=given))
    port = mapping.outputs.ports["quaternion"]
    angles = [30.0, 40.0, -50.0]
    q = read(port, mapping.outputs, dict(zip(["phi", "theta", "psi"], angles, strict=True)))
    assert q == pytest.approx(rotations.from_euler(np.radians(angles), order), abs=1e-15)
    values = np.zeros(mapping.outputs.size)
    port.write(q, values)
    assert values[port.index] == pytest.approx(angles, abs=1e-12)


@pytest.mark.parametrize("order", [None, "XXY", "xYz", "wxyz", "XY"])
def test_euler_angles_need_their_axes(order):
    rows = [variable(3, "angles", 50, "output", shape=(3,))]
    fmu = plant(without=["quaternion"], more=rows)
    refused(fmu, "signals.outputs.euler: needs `order`", outputs={"euler": Source(variable="angles", order=order)})


def test_units_are_converted():
    mapping = map_signals(plant(position="mm", cable_tension="kN"), ROBOT)
    assert read(mapping.outputs.ports["position"], mapping.outputs, {"position": [1, 2, 3]}) == pytest.approx(
        [0.001, 0.002, 0.003]
    )
    values = mapping.inputs.start()
    mapping.inputs.ports["cable_tension"].write(np.full(8, 500.0), values)
    assert values[:8] == pytest.approx(0.5)


def test_a_unit_of_another_kind_is_an_error():
    refused(plant(position="N"), "'position[1]' is in N, but this signal is measured in m")
    refused(plant(quaternion="m"), "this signal has no unit")
    refused(plant(external_wrench="N"), "'external_wrench[4]' is in N, but this signal is measured in N.m")


def test_radians_may_be_left_out_of_a_unit():
    map_signals(plant(angular_velocity="1/s"), ROBOT)


def test_a_missing_unit_is_read_as_si_with_a_notice():
    mapping = map_signals(plant(velocity=None), ROBOT)
    assert mapping.notices == ("outputs velocity: the FMU declares no unit, read as m/s",)
    assert mapping.outputs.ports["velocity"].scale.tolist() == [1.0] * 3


def test_a_unit_that_is_not_defined_is_read_by_its_name_with_a_notice():
    mapping = map_signals(plant(velocity="mm/s"), ROBOT)
    assert mapping.notices == ("outputs velocity: the FMU does not define its unit 'mm/s', read as that",)
    assert mapping.outputs.ports["velocity"].scale == pytest.approx(0.001)
    refused(plant(velocity="furlong/h"), "'furlong/h' is unknown and not defined by the FMU; set `unit:`")


def test_the_scenario_may_set_unit_and_sign():
    given = {"velocity": Source(variable="velocity", unit="mm/s", factor=-1.0)}
    mapping = map_signals(plant(), ROBOT, Signals(outputs=given))
    assert mapping.outputs.ports["velocity"].scale == pytest.approx([-0.001] * 3)
    wrench = {"external_wrench": Source(variable="external_wrench", unit=("kN",) * 3 + ("N.m",) * 3)}
    scale = map_signals(plant(), ROBOT, Signals(inputs=wrench)).inputs.ports["external_wrench"].scale
    assert scale.tolist() == [1000.0] * 3 + [1.0] * 3
    for source, words in (
        (Source(variable="velocity", unit="parsec"), "'parsec' is unknown and not defined"),
        (Source(variable="velocity", unit=("m/s",)), "expected 3 units, got 1"),
        (Source(variable="velocity", factor=0.0), "factor cannot be 0"),
        (Source(variable="velocity", unit="m"), "measured in m/s"),
    ):
        refused(plant(), words, outputs={"velocity": source})
