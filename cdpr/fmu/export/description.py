"""modelDescription.xml for FMI 2.0 and 3.0, buildDescription.xml, and the configuration that the binary reads."""

from __future__ import annotations

import itertools
import struct
from collections.abc import Sequence
from importlib.metadata import version
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from cdpr.fmu.export.variables import Model, Variable
from cdpr.units import BASE_UNITS, si

# Names the library, thus the same for all robots: the binary is generic.
IDENTIFIER = "cdpr_plant"

# s, only a proposal to the host for how long to simulate.
STOP_TIME = 1.0


def configuration(variables: Sequence[Variable], cables: int, token: str) -> str:
    """Return resources/plant.cfg; source/config.c says how it is laid out."""
    numbers = sum(variable.size for variable in variables)
    lines = [f"cdpr-plant 1 token {token} cables {cables} variables {len(variables)} numbers {numbers}"]
    for reference, variable in _referenced(variables):
        bits = [f"{struct.unpack('>Q', struct.pack('>d', value))[0]:016x}" for value in variable.values]
        lines.append(" ".join([variable.causality, variable.name, str(reference), str(variable.size), *bits]))
    return "\n".join(lines) + "\n"


def model_description(
    model: Model, variables: Sequence[Variable], token: str, fmi: int, sources: Sequence[str]
) -> bytes:
    """Return modelDescription.xml. In FMI 2 each number is a variable of its own, in FMI 3 arrays are."""
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
    if fmi == 2:
        simulation.set("canNotUseMemoryManagementFunctions", "true")  # those of the host
        files = SubElement(simulation, "SourceFiles")
        for name in sources:
            SubElement(files, "File", name=name)
    _units(root, public)
    categories = SubElement(root, "LogCategories")
    SubElement(categories, "Category", name="logStatusError", description="what went wrong, and what to do")
    SubElement(categories, "Category", name="logStatusWarning", description="what was asked for and cannot be")
    SubElement(root, "DefaultExperiment", startTime="0", stopTime=repr(STOP_TIME), stepSize=repr(model.physics_step))
    (_variables2 if fmi == 2 else _variables3)(root, public)
    return _text(root)


def build_description(sources: Sequence[str]) -> bytes:
    """Return sources/buildDescription.xml: what to compile for other platforms."""
    root = Element("fmiBuildDescription", fmiVersion="3.0")
    build = SubElement(root, "BuildConfiguration", modelIdentifier=IDENTIFIER)
    files = SubElement(build, "SourceFileSet", language="C99")
    for name in sources:
        SubElement(files, "SourceFile", name=name)
    return _text(root)


def _referenced(variables: Sequence[Variable]) -> list[tuple[int, Variable]]:
    """Each variable after its value reference."""
    ends = itertools.accumulate((variable.size for variable in variables), initial=0)
    return list(zip(ends, variables, strict=False))  # the last end begins nothing


def _units(root: Element, public: list[tuple[int, Variable]]) -> None:
    units = SubElement(root, "UnitDefinitions")
    for name in dict.fromkeys(variable.unit for _, variable in public if variable.unit):
        exponents = zip(BASE_UNITS, si(name).exponents or (), strict=True)
        powers = {base: str(power) for base, power in exponents if power}
        SubElement(SubElement(units, "Unit", name=name), "BaseUnit", powers)


def _variables2(root: Element, public: list[tuple[int, Variable]]) -> None:
    """One scalar variable for each number; the structure refers to them by their place, from 1."""
    section = SubElement(root, "ModelVariables")
    outputs: list[tuple[str, Variable]] = []
    for reference, variable in public:
        for i, index in enumerate(itertools.product(*(range(1, n + 1) for n in variable.shape))):
            name = variable.name + (f"[{','.join(map(str, index))}]" if index else "")
            scalar = SubElement(
                section, "ScalarVariable", {"name": name, "valueReference": str(reference + i), **_common(variable)}
            )
            start = _start(variable, variable.values[i : i + 1])
            SubElement(scalar, "Real", {**_unit(variable.unit), **_least(variable), **start})
            if variable.causality == "output":
                outputs.append((str(len(section)), variable))
    structure = SubElement(root, "ModelStructure")
    known = SubElement(structure, "Outputs")
    unknown = SubElement(structure, "InitialUnknowns")
    for place, variable in outputs:
        SubElement(known, "Unknown", {"index": place, **_dependencies(variable)})
        SubElement(unknown, "Unknown", index=place)


def _variables3(root: Element, public: list[tuple[int, Variable]]) -> None:
    section = SubElement(root, "ModelVariables")
    structure = SubElement(root, "ModelStructure")
    outputs = [(str(reference), variable) for reference, variable in public if variable.causality == "output"]
    for reference, variable in public:
        attributes = {"name": variable.name, "valueReference": str(reference), **_common(variable)}
        more = {**_unit(variable.unit), **_least(variable), **_start(variable, variable.values)}
        element = SubElement(section, "Float64", {**attributes, **more})
        for n in variable.shape:
            SubElement(element, "Dimension", start=str(n))
    for place, variable in outputs:
        SubElement(structure, "Output", {"valueReference": place, **_dependencies(variable)})
    for place, _ in outputs:
        SubElement(structure, "InitialUnknown", valueReference=place)


def _common(variable: Variable) -> dict[str, str]:
    attributes = {"description": variable.description, "causality": variable.causality}
    if variable.causality == "parameter":
        return {**attributes, "variability": "fixed", "initial": "exact"}
    if variable.causality == "output":
        return {**attributes, "variability": "continuous", "initial": "calculated"}
    return {**attributes, "variability": "continuous"}


def _dependencies(variable: Variable) -> dict[str, str]:
    """Say that an output depends on no input at the same instant, so that hosts see no algebraic loop."""
    return {} if variable.direct else {"dependencies": ""}


def _unit(unit: str) -> dict[str, str]:
    return {"unit": unit} if unit else {}


def _least(variable: Variable) -> dict[str, str]:
    return {} if variable.least is None else {"min": repr(variable.least)}


def _start(variable: Variable, values: Sequence[float]) -> dict[str, str]:
    given = variable.causality in ("parameter", "input")
    return {"start": " ".join(map(repr, values))} if given else {}


def _text(root: Element) -> bytes:
    ElementTree.indent(root)
    text = '<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"
    return text.encode()
