"""Metadata of an FMU, read from modelDescription.xml."""

from __future__ import annotations

import contextlib
import re

import numpy as np
import pytest
from conftest import crossed_box, make_robot
from fmu_cases import description, make_fmu, signals, variable

from cdpr.base.errors import FmuError
from cdpr.fmu.read.archive import open_archive
from cdpr.fmu.read.description import read_description
from cdpr.fmu.read.mapping import resolve
from cdpr.fmu.read.model import Element
from cdpr.fmu.read.options import Signals
from cdpr.fmu.run.parameters import Parameters

ROBOT = make_robot(crossed_box(np.random.default_rng(1), 2))


def read(xml):
    return read_description(xml.encode())


def refused(xml, words):
    with pytest.raises(FmuError) as caught:
        read(xml)
    assert words in str(caught.value)


@pytest.mark.parametrize("fmi", [2, 3])
def test_version_name_token_and_step(fmi):
    about = read(description(fmi))
    assert about.fmi == f"{fmi}.0"
    assert (about.name, about.token, about.identifier, about.default_step) == ("plant", "{1}", "plant", 0.001)


def test_patch_releases_are_known():
    assert read(description(3, version="3.0.2")).fmi == "3.0"


@pytest.mark.parametrize("version", ["1.0", "2.1", "3.1", "3.0-beta.2", "", "x"])
def test_other_versions_are_refused_by_name(version):
    refused(description(3).replace('fmiVersion="3.0"', f'fmiVersion="{version}"'), f"FMI {version}".strip())


@pytest.mark.parametrize(
    ("interface", "words"),
    [("ModelExchange", "for Model Exchange only"), ("ScheduledExecution", "for Scheduled Execution only"),
     ("Something", "has no <CoSimulation>")],
)  # fmt: skip
def test_other_interfaces_are_refused_by_name(interface, words):
    refused(description(3, interface=interface), words)


@pytest.mark.parametrize("fmi", [2, 3])
def test_capabilities(fmi):
    state = "FMUstate" if fmi == 2 else "FMUState"
    given = {
        f"canGetAndSet{state}": "true",
        "canHandleVariableCommunicationStepSize": "1",
        "needsExecutionTool": "false",
    }
    can = read(description(fmi, fixedInternalStepSize="0.002", **given)).capabilities
    assert (can.get_set_state, can.variable_step, can.serialize_state, can.needs_tool) == (True, True, False, False)
    assert can.fixed_internal_step == 0.002


def test_arrays_have_shapes_and_elements():
    about = read(description(3, [variable(3, "A", 7, "output", shape=(2, 3))]))
    A = about.by_name["A"]
    assert (A.shape, A.size, A.value_reference, A.kind) == ((2, 3), 6, 7, "Float64")
    found = about.find("A[2,1]")
    assert isinstance(found, Element)
    assert (found.index, found.name) == (3, "A[2,1]")
    assert [element.name for element in A.elements] == ["A[1,1]", "A[1,2]", "A[1,3]", "A[2,1]", "A[2,2]", "A[2,3]"]


@pytest.mark.parametrize("name", ["A[0,1]", "A[3,1]", "A[1]", "A[1,2,3]", "B", "A[", "s[1]"])
def test_elements_that_do_not_exist(name):
    about = read(description(3, [variable(3, "A", 1, "output", shape=(2, 3)), variable(3, "s", 2, "output")]))
    with pytest.raises(FmuError):
        about.find(name)


def test_a_dimension_may_be_the_start_of_another_variable():
    m = variable(3, "m", 1, "structuralParameter", kind="UInt64", start="4")
    T = variable(3, "T", 2, "input", shape=(0,), start="1 2 3 4").replace('start="0"/>', 'valueReference="1"/>')
    assert read(description(3, [m, T])).by_name["T"].shape == (4,)
    refused(description(3, [T]), "a dimension of 'T' has no size")


def test_names_of_fmi_2_with_brackets_are_names():
    about = read(description(2, signals(2, {"F": ("input", 3, "N")})))
    assert about.find("F[2]") is about.by_name["F[2]"]


def test_aliases():
    about = read(description(3, [variable(3, "x", 1, "output", alias="body.x")]))
    assert about.by_name["body.x"] is about.by_name["x"]
    rows = [variable(2, "x", 5, "output"), variable(2, "y", 5, "local")]
    x, y = read(description(2, rows)).variables  # two names of one value, each a variable
    assert x.value_reference == y.value_reference == 5


def test_units_come_from_the_definitions_or_the_declared_type():
    types = '<TypeDefinitions><Float64Type name="Force" unit="kN"/></TypeDefinitions>'
    rows = [
        variable(3, "own", 1, "output", unit="mm"),
        variable(3, "typed", 2, "output").replace("<Float64", '<Float64 declaredType="Force"', 1),
        variable(3, "unknown", 3, "output", unit="furlong"),
        variable(3, "none", 4, "output"),
    ]
    by_name = read(description(3, rows, more=types)).by_name
    assert (by_name["own"].unit.factor, by_name["own"].unit.exponents) == (0.001, (0, 1, 0, 0, 0, 0, 0, 0))
    assert by_name["typed"].unit.factor == 1000
    assert by_name["unknown"].unit.exponents is None
    assert by_name["none"].unit is None


def test_letters_that_a_terminal_would_obey_are_escaped():
    about = read(description(3, [variable(3, "x&#x9b;2J&#10;y", 1, "output")]).replace("&amp;", "&"))
    assert about.variables[0].name == r"x\x9b2J\ny"


def test_terminals(tmp_path):
    xml = b"""<fmiTerminalsAndIcons><Terminals><Terminal name="platform">
      <TerminalMemberVariable variableName="body.r" memberName="position"/></Terminal>
      </Terminals></fmiTerminalsAndIcons>"""
    opened = open_archive(make_fmu(tmp_path / "a.fmu", files={"terminalsAndIcons/terminalsAndIcons.xml": xml}))
    assert opened.description.terminals == ({"position": "body.r"},)


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        ([variable(3, "x", -1, "output")], "value reference -1"),
        ([variable(3, "x", 2**32, "output")], "value reference"),
        ([variable(3, "x", 1, "output").replace('"1"', '"one"')], "needs a whole number as valueReference, got 'one'"),
        ([variable(3, "x", 1, "output"), variable(3, "x", 2, "output")], "two variables 'x'"),
        ([variable(3, "x", 1, "output").replace('name="x"', "")], "a variable has no name"),
        ([variable(3, "x", 1, "input", start="zero")], "'x' starts with 'zero'"),
        ([variable(3, "x", 1, "input", start="nan")], "'x' starts with 'nan'"),
        ([variable(3, "x", 1, "input", shape=(3,), start="1 2")], "expected 3 numbers"),
        ([variable(3, "x", 1, "output", shape=(0,))], "1 to 1000000 elements"),
        ([variable(3, "x", 1, "output", shape=(10**6, 10**6))], "1 to 1000000 elements"),
        ([variable(3, "x", 1, "output", shape=(3,)).replace('start="3"', 'start="3.5"')], "got '3.5'"),
    ],
)
def test_variables_that_are_not_sound(rows, words):
    refused(description(3, rows), words)


def test_other_mistakes():
    refused("<other/>", "got <other>")
    refused("<fmiModelDescription", "not sound XML")
    refused(description(3, units={"N": {"factor": 0}}), "factor 0")
    refused(description(3, units={"N": {"kg": 0.5}}), "needs a whole number as kg")
    refused(description(3, units={"N": {"factor": "inf"}}), "needs a number as factor")
    refused(description(3).replace('stepSize="0.001"', 'stepSize="soon"'), "needs a number as stepSize")


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize(
    "junk", ["", "-1", "0", "abc", "1e999", "9" * 5000, "²", "1 2", "\t", "[1]", "position", "{i}"]
)
@pytest.mark.usual("*-3", "0-2")
def test_any_attribute_gives_an_fmu_or_an_error(fmi, junk):
    rows = signals(fmi, {"cable_tension": ("input", 2, "N"), "position": ("output", 3, "m")})
    xml = description(
        fmi, rows, more="<TypeDefinitions><SimpleType name='a'/></TypeDefinitions>", fixedInternalStepSize=1
    )
    places = [match.span(1) for match in re.finditer('="([^"]*)"', xml)][2:]  # not those of the XML declaration
    for start, stop in places:
        with contextlib.suppress(FmuError):
            about = read(f"{xml[:start]}{junk}{xml[stop:]}")
            resolve(about, ROBOT, Signals(cable_order=(2, 1)), "plant")


@pytest.mark.parametrize("fmi", [2, 3])
def test_any_omission_gives_an_fmu_or_an_error(fmi):
    xml = description(fmi)
    for match in re.finditer(r'<[^?][^>]*/>| \w+="[^"]*"', xml):
        with contextlib.suppress(FmuError):
            resolve(read(xml[: match.start()] + xml[match.end() :]), ROBOT, Signals(), "controller")


@pytest.mark.parametrize("text", ["2_0", "\u0663", "\uff15", "1e0", "0x1", "", " ", "1" * 5000, "-1"])
@pytest.mark.parametrize("fmi", [2, 3])
def test_value_references_are_whole_numbers_in_ascii(text, fmi):
    refused(description(fmi, [variable(fmi, "x", text, "output")]), "value")


@pytest.mark.parametrize("text", ["1_0", "\u0663", "0x1p3", "inf", "INF", "nan", "1e999", ".", "1e", ""])
def test_numbers_are_written_as_in_xml(text):
    refused(description(2, [variable(2, "x", 1, "input", start=text)]), "expected 1 numbers")
    refused(description(3, [], units={"u": {"m": 1, "factor": text}}), "needs a number as factor")
    refused(description(3, [variable(3, "n", 1, "parameter", kind="Int32", start=text)]), "of the kind Int32")
    refused(description(3, [variable(3, "f", 1, "parameter", kind="Float32", start=text)]), "of the kind Float32")
    refused(description(3, [variable(3, "b", 1, "parameter", kind="Boolean", start=text)]), "of the kind Boolean")


@pytest.mark.parametrize("text", ["1", "-1.5", "+2.", ".5", "1E-3", " 7 "])
def test_numbers_of_xml_are_read(text):
    assert read(description(2, [variable(2, "x", 1, "input", start=text)])).variables[0].start == (text,)


def test_many_names_of_one_value_take_room_in_proportion():
    """20 000 aliases of 60 kB once took 3 GB: each held the names of all others."""
    n = 3000
    about = read(description(2, [variable(2, f"v{i}", 1, "local") for i in range(n)]))
    assert len(about.by_name) == n
    assert sum(len(each.names) for each in about.variables) == n


def test_an_array_of_many_dimensions_is_refused():
    row = variable(3, "x", 1, "local", shape=(1,) * 50_000)
    refused(description(3, [row]), "expected 1 to 1000000 elements")


@pytest.mark.parametrize("fmi", [2, 3])
def test_names_without_end_are_refused(fmi):
    refused(description(fmi, [variable(fmi, "x" * 1001, 1, "local")]), "has a name of 1001 letters, more than 1000")
    refused(description(fmi, [variable(fmi, "x", 1, "local", unit="m" * 1001)]), "has a unit of 1001 letters")


@pytest.mark.parametrize(
    ("fmi", "kind", "least", "most"),
    [(3, "Int8", -128, 127), (3, "UInt8", 0, 255), (2, "Integer", -(2**31), 2**31 - 1), (3, "UInt64", 0, 2**64 - 1)],
)
def test_parameters_hold_what_they_are_given(fmi, kind, least, most):
    """An Int8 once made 44 of 300, without a word."""
    parameters = Parameters(read(description(fmi, [variable(fmi, "n", 1, "parameter", kind=kind)])))
    for value in (least, most):
        parameters.give({"n": value})
        assert parameters.settings()[0].values == (value,)
    for value in (least - 1, most + 1):
        with pytest.raises(FmuError, match=f"{value} is beyond what a variable of the kind {kind} can hold"):
            parameters.give({"n": value})
