"""Mapping of an FMU's variables to signals: by the scenario, by certain rules, or not at all."""

from __future__ import annotations

import numpy as np
import pytest
from fmu_cases import PLANT, signals, variable
from mapping_cases import ROBOT, about, names, plant, refused

from cdpr.fmu.read.mapping import map_signals
from cdpr.fmu.read.options import Signals, Source


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
    told = refused(plant(2, more=rows), "cable_tension: ambiguous:", "cable_tension[1] ... cable_tension[8]")
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
    refused(read_with(fmu, terminals=({"position": "a.r"}, {"position": "b.r"})), "position: ambiguous: a.r or b.r")


def read_with(fmu, **changes):
    from dataclasses import replace

    return replace(fmu, **changes)


def test_usual_names_are_mapped_if_length_and_unit_agree():
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
    refused(plant(without=["cable_tension"], more=rows), "ambiguous: tension or F; choose one under signals.inputs")


def test_the_name_beats_the_usual_name():
    rows = [variable(3, "F", 50, "input", shape=(8,), unit="N")]
    mapping = map_signals(plant(more=rows), ROBOT)
    assert names(mapping.inputs.ports["cable_tension"])[0] == "cable_tension[1]"
    assert mapping.notices == ("inputs without a signal, which keep their start value: F",)


def test_unassigned_inputs_are_reported_unless_set_to_none():
    assert map_signals(plant(), ROBOT, Signals(inputs={"external_wrench": "none"})).notices == ()
    mapping = map_signals(plant(more=[variable(3, "wind", 50, "input")]), ROBOT)
    assert mapping.notices == ("inputs without a signal, which keep their start value: wind",)


def test_wrong_direction_or_kind_is_never_found():
    rows = [variable(3, "position", 50, "local", shape=(3,), unit="m")]
    refused(plant(without=["position"], more=rows), "position: needed")
    rows = [variable(3, "position", 50, "output", shape=(3,), unit="m", kind="Float32")]
    refused(plant(without=["position"], more=rows), "position: needed")


def test_required_keys_depend_on_the_robot():
    point = ROBOT.replace(dof=("x", "z"))
    fmu = plant(without=["quaternion", "angular_velocity", "external_wrench"])
    assert "quaternion" not in map_signals(fmu, point).outputs.ports
    refused(fmu, "quaternion: needed", "angular_velocity: needed")


def test_tension_or_command_but_not_both():
    rows = [variable(3, "command", 50, "input", shape=(8,), unit="N")]
    refused(plant(more=rows), "both cable_tension and command; set one of them to `none`")
    mapping = map_signals(plant(more=rows), ROBOT, Signals(inputs={"command": "none"}))
    assert "cable_tension" in mapping.inputs.ports
    mapping = map_signals(plant(without=["cable_tension"], more=rows), ROBOT)
    assert "command" in mapping.inputs.ports
    refused(plant(), "is needed", inputs={"cable_tension": "none"})


def test_all_errors_are_reported_together():
    told = refused(
        plant(without=["position", "velocity"]), inputs={"cable_tensions": "x", "external_wrench": "nothing"}
    )
    assert len(told.splitlines()) == 4
    assert "signals.inputs.cable_tensions: unknown signal" in told
    assert "did you mean 'cable_tension'?" in told
    assert "signals.inputs.external_wrench: no input with 6 numbers is named 'nothing'" in told


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
    assert notice == "the FMU receives no part of the state: an open-loop controller, or one that contains a plant"
    rows = signals(3, {"wrench": ("output", 6, None), "command": ("output", 8, "N")})
    refused(about(3, rows), "both wrench and command", role="controller")
    refused(
        about(3, signals(3, {"x": ("input", 3, "m")})), "wrench (6 numbers) or command (8 numbers)", role="controller"
    )


def test_the_record_of_a_run_is_complete():
    given = {"euler": Source(variable="angles", order="XYZ")}
    fmu = plant(without=["quaternion"], more=[variable(3, "angles", 50, "output", shape=(3,), unit="deg")])
    record = map_signals(fmu, ROBOT, Signals(outputs=given)).describe()
    assert record["role"] == "plant"
    assert [each["signal"] for each in record["inputs"]] == ["cable_tension", "external_wrench"]
    row = next(each for each in record["outputs"] if each["signal"] == "quaternion")
    assert row["variables"] == ["angles[1]", "angles[2]", "angles[3]"]
    assert (row["units"], row["euler"], row["rule"]) == (["deg"] * 3, "XYZ", "given")
