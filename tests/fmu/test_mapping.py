"""Which variables of an FMU are which signals: by the scenario's word, by certain rules, or not at all."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import crossed_box, make_robot
from fmu_cases import PLANT, description, signals, variable

from cdpr.base.errors import FmuError
from cdpr.fmu.read.description import read_description
from cdpr.fmu.read.mapping import map_signals, resolve
from cdpr.fmu.read.options import Signals, Source
from cdpr.model import rotations

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


@pytest.mark.parametrize("fmi", [2, 3])
def test_signals_called_as_in_cdpr_map_by_themselves(fmi):
    mapping = map_signals(plant(fmi), ROBOT)
    assert list(mapping.inputs.ports) == ["cable_tension", "external_wrench"]
    assert list(mapping.outputs.ports) == ["position", "quaternion", "velocity", "angular_velocity", "cable_length"]
    assert names(mapping.outputs.ports["velocity"]) == ["velocity[1]", "velocity[2]", "velocity[3]"]
    assert {port.rule for port in mapping.outputs.ports.values()} == {"name"}
    assert mapping.inputs.size == 14
    values = mapping.inputs.start()
    mapping.inputs.ports["cable_tension"].write(np.arange(8.0), values)
    mapping.inputs.ports["external_wrench"].write(np.arange(10.0, 16.0), values)
    assert values.tolist() == [*range(8), *range(10, 16)]


@pytest.mark.parametrize("pattern", ["{}_{}", "{}{}", "{}[{}]"])
@pytest.mark.parametrize("first", [0, 1])
def test_families(pattern, first):
    rows = [variable(2, pattern.format("cable_tension", i), 100 - i, "input") for i in range(first, first + 8)]
    mapping = map_signals(plant(2, without=["cable_tension"], more=rows), ROBOT)
    assert names(mapping.inputs.ports["cable_tension"]) == [
        pattern.format("cable_tension", first + i) for i in range(8)
    ]


def test_a_family_with_a_gap_or_of_another_size_is_none():
    rows = [variable(2, f"cable_tension[{i}]", 100 + i, "input") for i in (1, 2, 3, 4, 5, 6, 7, 9)]
    refused(plant(2, without=["cable_tension"], more=rows), "cable_tension (8 numbers)", "is needed")
    rows = [variable(2, f"cable_tension[{i}]", 100 + i, "input") for i in range(1, 10)]
    refused(plant(2, without=["cable_tension"], more=rows), "is needed")
    rows = [variable(2, f"cable_tension[{i}]", 100 + i, "input") for i in range(9)]
    refused(plant(2, without=["cable_tension"], more=rows), "is needed")


def test_components_have_names_and_so_an_order():
    rows = [variable(2, f"quaternion.{part}", 100 + i, "output") for i, part in enumerate("zyxw")]
    rows += [variable(2, f"position_{part}", 110 + i, "output", unit="m") for i, part in enumerate("yzx")]
    mapping = map_signals(plant(2, without=["quaternion", "position"], more=rows), ROBOT)
    assert names(mapping.outputs.ports["quaternion"]) == [f"quaternion.{part}" for part in "wxyz"]
    assert names(mapping.outputs.ports["position"]) == [f"position_{part}" for part in "xyz"]


def test_the_order_of_declaration_never_counts():
    rows = signals(2, PLANT)
    forwards, backwards = map_signals(about(2, rows), ROBOT), map_signals(about(2, rows[::-1]), ROBOT)
    assert forwards.describe() == backwards.describe()
    assert forwards.outputs.value_references == backwards.outputs.value_references


def test_two_families_of_one_name_are_an_error():
    rows = [variable(2, f"cable_tension_{i}", 100 + i, "input") for i in range(8)]
    told = refused(plant(2, more=rows), "cable_tension: may be", "cable_tension[1] ... cable_tension[8]")
    assert "cable_tension_0 ... cable_tension_7" in told


def test_aliases_count_as_names():
    rows = [variable(3, "body.r", 50, "output", shape=(3,), unit="m", alias="position")]
    mapping = map_signals(plant(without=["position"], more=rows), ROBOT)
    assert names(mapping.outputs.ports["position"]) == ["body.r[1]", "body.r[2]", "body.r[3]"]


def test_an_alias_is_no_second_candidate():
    rows = [variable(2, f"r[{i}]", 14 + i, "output", unit="m") for i in (1, 2, 3)]  # the references of position
    assert map_signals(plant(2, more=rows), ROBOT).outputs.ports["position"].rule == "name"


def test_terminals():
    fmu = plant(without=["position"], more=[variable(3, "body.r", 50, "output", shape=(3,), unit="m")])
    fmu = read_with(fmu, terminals=({"position": "body.r"},))
    port = map_signals(fmu, ROBOT).outputs.ports["position"]
    assert (port.rule, names(port)[0]) == ("terminal", "body.r[1]")
    fmu = plant(
        without=["position"], more=[variable(3, f"{n}.r", 50 + i, "output", shape=(3,)) for i, n in enumerate("ab")]
    )
    refused(read_with(fmu, terminals=({"position": "a.r"}, {"position": "b.r"})), "position: may be a.r or b.r")


def read_with(fmu, **changes):
    from dataclasses import replace

    return replace(fmu, **changes)


def test_usual_names_are_believed_where_length_and_unit_agree():
    rows = [variable(3, "F", 50, "input", shape=(8,), unit="kN"), variable(3, "q", 51, "output", shape=(4,))]
    mapping = map_signals(plant(without=["cable_tension", "quaternion"], more=rows), ROBOT)
    assert mapping.inputs.ports["cable_tension"].rule == "usual name"
    assert mapping.inputs.ports["cable_tension"].scale.tolist() == [1000.0] * 8
    assert names(mapping.outputs.ports["quaternion"]) == ["q[1]", "q[2]", "q[3]", "q[4]"]


def test_a_unit_without_definition_is_known_by_its_name():
    """As Dymola writes "1" and "kg/kg"."""
    rows = [variable(3, "F", 50, "input", shape=(8,), unit="mN"), variable(3, "q", 51, "output", shape=(4,), unit="1")]
    mapping = map_signals(plant(without=["cable_tension", "quaternion"], more=rows), ROBOT)
    assert mapping.inputs.ports["cable_tension"].scale.tolist() == [0.001] * 8
    assert mapping.notices == ("inputs cable_tension: the FMU does not define its unit 'mN', read as that",)


@pytest.mark.parametrize(("shape", "unit"), [((8,), None), ((8,), "m"), ((7,), "N"), ((8,), "furlong")])
def test_usual_names_are_not_believed_otherwise(shape, unit):
    rows = [variable(3, "F", 50, "input", shape=shape, unit=unit)]
    refused(plant(without=["cable_tension"], more=rows), "is needed")


def test_two_usual_names_are_an_error():
    rows = [variable(3, name, 50 + i, "input", shape=(8,), unit="N") for i, name in enumerate(["F", "tension"])]
    refused(plant(without=["cable_tension"], more=rows), "may be tension or F; say which under signals.inputs")


def test_the_name_beats_the_usual_name():
    rows = [variable(3, "F", 50, "input", shape=(8,), unit="N")]
    mapping = map_signals(plant(more=rows), ROBOT)
    assert names(mapping.inputs.ports["cable_tension"])[0] == "cable_tension[1]"
    assert mapping.notices == ("inputs that keep their start value: F",)


def test_inputs_left_alone_are_told_unless_the_scenario_says_none():
    assert map_signals(plant(), ROBOT, Signals(inputs={"external_wrench": "none"})).notices == ()
    mapping = map_signals(plant(more=[variable(3, "wind", 50, "input")]), ROBOT)
    assert mapping.notices == ("inputs that keep their start value: wind",)


def test_wrong_direction_or_kind_is_never_found():
    rows = [variable(3, "position", 50, "local", shape=(3,), unit="m")]
    refused(plant(without=["position"], more=rows), "position: needed")
    rows = [variable(3, "position", 50, "output", shape=(3,), unit="m", kind="Float32")]
    refused(plant(without=["position"], more=rows), "position: needed")


def test_what_is_needed_depends_on_the_robot():
    point = make_robot(crossed_box(np.random.default_rng(1), 8)).__class__(
        "p", ROBOT.platform, ROBOT.cables, ("x", "z")
    )
    fmu = plant(without=["quaternion", "angular_velocity", "external_wrench"])
    assert "quaternion" not in map_signals(fmu, point).outputs.ports
    refused(fmu, "quaternion: needed", "angular_velocity: needed")


def test_tension_or_command_but_not_both():
    rows = [variable(3, "command", 50, "input", shape=(8,), unit="N")]
    refused(plant(more=rows), "both cable_tension and command; say `none` for one of them")
    mapping = map_signals(plant(more=rows), ROBOT, Signals(inputs={"command": "none"}))
    assert "cable_tension" in mapping.inputs.ports
    mapping = map_signals(plant(without=["cable_tension"], more=rows), ROBOT)
    assert "command" in mapping.inputs.ports
    refused(plant(), "is needed", inputs={"cable_tension": "none"})


def test_all_that_is_wrong_is_told_at_once():
    told = refused(
        plant(without=["position", "velocity"]), inputs={"cable_tensions": "x", "external_wrench": "nothing"}
    )
    assert len(told.splitlines()) == 4
    assert "signals.inputs.cable_tensions: is no signal here" in told
    assert "did you mean 'cable_tension'?" in told
    assert "signals.inputs.external_wrench: 'nothing' is no input with 6 numbers" in told


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
def test_what_the_scenario_names(given, expected):
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


def test_outputs_may_be_local_if_the_scenario_says_so():
    rows = [variable(3, "r", 50, "local", shape=(3,), unit="m")]
    mapping = map_signals(plant(without=["position"], more=rows), ROBOT, Signals(outputs={"position": "r"}))
    assert names(mapping.outputs.ports["position"])[0] == "r[1]"


def test_one_number_is_not_two_signals():
    refused(
        plant(),
        "'position[1]' is already taken for position",
        outputs={"velocity": Source(variable="position", unit="m/s")},
    )
    rows = [variable(2, f"other[{i}]", i, "input") for i in range(1, 9)]  # aliases of cable_tension
    refused(plant(2, more=rows), "already taken", inputs={"command": "other[{i}]"})


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
        refused(plant(), "cable_order: the numbers from 1 to 8", cable_order=wrong)


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
    refused(plant(velocity="furlong/h"), "'furlong/h' is not defined by the FMU and not known; say `unit:`")


def test_the_scenario_may_say_the_unit_and_turn_the_sign():
    given = {"velocity": Source(variable="velocity", unit="mm/s", factor=-1.0)}
    mapping = map_signals(plant(), ROBOT, Signals(outputs=given))
    assert mapping.outputs.ports["velocity"].scale == pytest.approx([-0.001] * 3)
    wrench = {"external_wrench": Source(variable="external_wrench", unit=("kN",) * 3 + ("N.m",) * 3)}
    scale = map_signals(plant(), ROBOT, Signals(inputs=wrench)).inputs.ports["external_wrench"].scale
    assert scale.tolist() == [1000.0] * 3 + [1.0] * 3
    for source, words in (
        (Source(variable="velocity", unit="parsec"), "'parsec' is not defined"),
        (Source(variable="velocity", unit=("m/s",)), "3 units are expected, got 1"),
        (Source(variable="velocity", factor=0.0), "factor cannot be 0"),
        (Source(variable="velocity", unit="m"), "measured in m/s"),
    ):
        refused(plant(), words, outputs={"velocity": source})


def test_winches():
    rows = signals(
        3, {"command": ("input", 8, "N.m"), "cable_length": ("input", 8, "mm"), "tension": ("output", 8, "N")}
    )
    mapping = map_signals(about(3, rows), ROBOT, role="winch")
    assert list(mapping.inputs.ports) == ["command", "cable_length"]
    assert mapping.inputs.ports["command"].units == ("N.m",) * 8  # a torque: any kind of command
    assert list(mapping.outputs.ports) == ["cable_tension"]


def test_controllers():
    rows = signals(
        3,
        {
            "position": ("input", 3, "m"),
            "desired_position": ("input", 3, "mm"),
            "desired_orientation": ("input", 4, None),
            "velocity_desired": ("input", 3, "m/s"),
            "wrench": ("output", 6, None),
        },
    )
    mapping = map_signals(about(3, rows), ROBOT, role="controller")
    assert list(mapping.inputs.ports) == ["position", "desired_position", "desired_quaternion", "desired_velocity"]
    assert list(mapping.outputs.ports) == ["wrench"]
    assert not any("state" in notice for notice in mapping.notices)
    rows = signals(3, {"desired_position": ("input", 3, "m"), "wrench": ("output", 6, None)})
    (notice,) = (each for each in map_signals(about(3, rows), ROBOT, role="controller").notices if "state" in each)
    assert notice == "nothing of the state goes in: a controller in open loop, or one with its own plant inside"
    rows = signals(3, {"wrench": ("output", 6, None), "command": ("output", 8, "N")})
    refused(about(3, rows), "both wrench and command", role="controller")
    refused(
        about(3, signals(3, {"x": ("input", 3, "m")})), "wrench (6 numbers) or command (8 numbers)", role="controller"
    )


def test_the_record_of_a_run_tells_all():
    given = {"euler": Source(variable="angles", order="XYZ")}
    fmu = plant(without=["quaternion"], more=[variable(3, "angles", 50, "output", shape=(3,), unit="deg")])
    record = map_signals(fmu, ROBOT, Signals(outputs=given)).describe()
    assert record["role"] == "plant"
    assert [each["signal"] for each in record["inputs"]] == ["cable_tension", "external_wrench"]
    row = next(each for each in record["outputs"] if each["signal"] == "quaternion")
    assert row["variables"] == ["angles[1]", "angles[2]", "angles[3]"]
    assert (row["units"], row["euler"], row["rule"]) == (["deg"] * 3, "XYZ", "given")
