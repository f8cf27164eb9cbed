"""modelDescription.xml for FMI 2.0 and 3.0, buildDescription.xml, and the configuration file of the binary."""

from __future__ import annotations

import itertools
import math
import struct
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from cdpr.base.units import BASE_UNITS, si
from cdpr.fmu.export.parts import states_in, width_of
from cdpr.fmu.export.variables import Model, Variable
from cdpr.native.exported_pipeline import Array, Operation

# Name of the library, equal for all robots: the binary is generic.
IDENTIFIER = "cdpr_plant"

# Names of the standard; source/instance.c uses them, too.
CATEGORIES = {
    "logStatusError": "problems and remedies",
    "logStatusWarning": "requests that cannot be executed",
    "logEvents": "with debug logging: a simulation continues with other parameters",
    "logAll": "all of these",
}

TERMINALS = {
    "desired": "desired motion of the platform",
    "platform": "state of the platform, and external wrench",
    "cables": "wrench of the cables on the platform",
    "winches": "commands and states of the winches",
}

# s, a proposal to the host for the duration of a simulation
STOP_TIME = 1.0


def configuration(model: Model, token: str) -> str:
    """Return resources/plant.cfg; source/config.cpp documents the format."""
    variables, pipeline = model.variables(), model.pipeline()
    stored = [(array, _words_of(array.content)) for array in pipeline.arrays]
    work = sum(len(words) for array, words in stored if array.kind == "work")
    numbers = sum(len(words) for _, words in stored) - work
    lines = [
        f"cdpr-plant 3 token {token} cables {model.robot.m} width {width_of(model.robot)} states {states_in(pipeline)} "
        f"variables {len(variables)} "
        f"numbers {sum(variable.size for variable in variables)} arrays {len(stored)} {numbers} {work} "
        f"links {len(pipeline.links)} operations {len(pipeline.operations)}"
    ]
    places = {}
    for reference, variable in _referenced(variables):
        places[variable.name] = reference
        fixed = variable.causality == "parameter" and not variable.tunable
        role = "fixed" if fixed else variable.causality
        bits = map(_number, variable.values)
        lines.append(" ".join([role, variable.name, variable.unit or "-", str(reference), str(variable.size), *bits]))
    for array, words in stored:
        lines.append(" ".join([array.name, array.kind, str(len(words)), *(words if array.kind != "work" else ())]))
    for link in pipeline.links:
        source, flags = places[link.variable] + link.first, (int(link.positive), int(link.per_step))
        lines.append(" ".join(map(str, [source, link.size, link.array, link.to, *flags])))
    return "\n".join([*lines, *map(_operation_line, pipeline.operations)]) + "\n"


def _operation_line(operation: Operation) -> str:
    texts = [
        f"value {member.value:016x}" if member.array is None else f"array {member.array} {member.value}"
        for member in operation.members
    ]
    head = [operation.name, int(operation.in_order), operation.vital, operation.skip, operation.repair, len(texts)]
    return " ".join([*map(str, head), *texts])


def _words_of(content: Array) -> list[str]:
    """Return the numbers of an array in the format of config.cpp."""
    if content.dtype == np.int64:
        return [f"{value:016x}" for value in np.ravel(content).view(np.uint64).tolist()]
    return [_number(value) for value in np.ravel(content).tolist()]


def _number(value: float) -> str:
    """Return the bits of a number as hexadecimal digits."""
    return f"{struct.unpack('>Q', struct.pack('>d', value))[0]:016x}"


def model_description(model: Model, variables: Sequence[Variable], token: str, fmi: int) -> bytes:
    """Return modelDescription.xml. In FMI 2 each number is a separate variable, in FMI 3 arrays are variables."""
    public = [
        (reference, variable) for reference, variable in _referenced(variables) if variable.causality != "constant"
    ]
    root = Element(
        "fmiModelDescription",
        {
            "fmiVersion": "2.0" if fmi == 2 else "3.0",
            "modelName": model.name,
            "guid" if fmi == 2 else "instantiationToken": token,
            "description": model.description,
            "generationTool": f"cdpr {version('cdpr')}",
            "variableNamingConvention": "structured",
        },
    )
    state = "FMUstate" if fmi == 2 else "FMUState"
    simulation = SubElement(
        root,
        "CoSimulation",
        {
            "modelIdentifier": IDENTIFIER,
            "canHandleVariableCommunicationStepSize": "true",
            f"canGetAndSet{state}": "true",
            f"canSerialize{state}": "true",
        },
    )
    if model.differentiable:
        simulation.set(f"providesDirectionalDerivative{'' if fmi == 2 else 's'}", "true")
    if fmi == 2:
        simulation.set("canNotUseMemoryManagementFunctions", "true")  # instances of the host
    _units(root, public)
    categories = SubElement(root, "LogCategories")
    for category, text in CATEGORIES.items():
        SubElement(categories, "Category", name=category, description=text)
    SubElement(root, "DefaultExperiment", startTime="0", stopTime=repr(STOP_TIME), stepSize=repr(model.physics_step))
    (_variables2 if fmi == 2 else _variables3)(root, public)
    return _text(root)


def build_description(sources: Sequence[str]) -> bytes:
    """Return sources/buildDescription.xml: the build for other platforms."""
    root = Element("fmiBuildDescription", fmiVersion="3.0")
    build = SubElement(root, "BuildConfiguration", modelIdentifier=IDENTIFIER)
    files = SubElement(build, "SourceFileSet", language="C++17")
    for name in sources:
        SubElement(files, "SourceFile", name=name)
    SubElement(files, "IncludeDirectory", name=".")
    return _text(root)


def terminals(variables: Sequence[Variable]) -> bytes:
    """Return terminalsAndIcons.xml of FMI 3: groups of variables, named as cdpr's signals."""
    root = Element("fmiTerminalsAndIcons", fmiVersion="3.0")
    section = SubElement(root, "Terminals")
    for name in dict.fromkeys(variable.terminal for variable in variables if variable.terminal):
        terminal = SubElement(section, "Terminal", name=name, matchingRule="plug", description=TERMINALS[name])
        for variable in variables:
            if variable.terminal == name:
                names = {"variableName": variable.name, "memberName": variable.name}
                SubElement(terminal, "TerminalMemberVariable", {**names, "variableKind": "signal"})
    return _text(root)


def _referenced(variables: Sequence[Variable]) -> list[tuple[int, Variable]]:
    """Yield each variable with its value reference."""
    ends = itertools.accumulate((variable.size for variable in variables), initial=0)
    return list(zip(ends, variables, strict=False))  # nothing begins at the end of the last one


def _units(root: Element, public: list[tuple[int, Variable]]) -> None:
    units = SubElement(root, "UnitDefinitions")
    for name in dict.fromkeys(variable.unit for _, variable in public if variable.unit):
        exponents = zip(BASE_UNITS, si(name).exponents or (), strict=True)
        powers = {base: str(power) for base, power in exponents if power}
        SubElement(SubElement(units, "Unit", name=name), "BaseUnit", powers)


def _variables2(root: Element, public: list[tuple[int, Variable]]) -> None:
    """Write one scalar variable for each number; the structure refers to them by their position, from 1."""
    section = SubElement(root, "ModelVariables")
    outputs: list[tuple[str, Variable]] = []
    places: dict[str, list[str]] = {}
    for reference, variable in public:
        for i, index in enumerate(itertools.product(*(range(1, n + 1) for n in variable.shape))):
            name = variable.name + (f"[{','.join(map(str, index))}]" if index else "")
            places.setdefault(variable.name, []).append(str(len(section) + 1))
            scalar = SubElement(
                section, "ScalarVariable", {"name": name, "valueReference": str(reference + i), **_common(variable)}
            )
            start = _start(variable, variable.values[i : i + 1])
            SubElement(scalar, "Real", {**_unit(variable.unit), **_bounds(variable), **start})
            if variable.causality == "output":
                outputs.append((str(len(section)), variable))
    structure = SubElement(root, "ModelStructure")
    known = SubElement(structure, "Outputs")
    unknown = SubElement(structure, "InitialUnknowns")
    for place, variable in outputs:
        SubElement(known, "Unknown", {"index": place, **_dependencies(variable.direct, places)})
        SubElement(unknown, "Unknown", {"index": place, **_dependencies(variable.initial, places)})


def _variables3(root: Element, public: list[tuple[int, Variable]]) -> None:
    section = SubElement(root, "ModelVariables")
    structure = SubElement(root, "ModelStructure")
    places = {variable.name: [str(reference)] for reference, variable in public}
    outputs = [(str(reference), variable) for reference, variable in public if variable.causality == "output"]
    for reference, variable in public:
        attributes = {"name": variable.name, "valueReference": str(reference), **_common(variable)}
        more = {**_unit(variable.unit), **_bounds(variable), **_start(variable, variable.values)}
        element = SubElement(section, "Float64", {**attributes, **more})
        for n in variable.shape:
            SubElement(element, "Dimension", start=str(n))
    for place, variable in outputs:
        SubElement(structure, "Output", {"valueReference": place, **_dependencies(variable.direct, places)})
    for place, variable in outputs:
        SubElement(structure, "InitialUnknown", {"valueReference": place, **_dependencies(variable.initial, places)})


def _common(variable: Variable) -> dict[str, str]:
    attributes = {"description": variable.description, "causality": variable.causality}
    if variable.causality == "parameter":
        return {**attributes, "variability": "tunable" if variable.tunable else "fixed", "initial": "exact"}
    if variable.causality == "output":
        return {**attributes, "variability": "continuous", "initial": "calculated"}
    return {**attributes, "variability": "continuous"}


def _dependencies(known: Sequence[str] | None, places: Mapping[str, Sequence[str]]) -> dict[str, str]:
    """Write the dependencies of an output, so that hosts find no false algebraic loop; none are written for all."""
    if known is None:
        return {}
    return {"dependencies": " ".join(place for name in known for place in places[name])}


def _unit(unit: str) -> dict[str, str]:
    return {"unit": unit} if unit else {}


def _bounds(variable: Variable) -> dict[str, str]:
    bounds = {"min": variable.least, "max": variable.most, "nominal": variable.nominal}
    return {name: repr(value) for name, value in bounds.items() if value is not None and math.isfinite(value)}


def _start(variable: Variable, values: Sequence[float]) -> dict[str, str]:
    given = variable.causality in ("parameter", "input")
    return {"start": " ".join(map(repr, values))} if given else {}


def _text(root: Element) -> bytes:
    ElementTree.indent(root)
    text = '<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"
    return text.encode()
