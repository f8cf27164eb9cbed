"""Parser of modelDescription.xml.

It uses the standard library, not FMPy: nothing here may load native code or a second XML parser, every fault needs one
clear line, and `cdpr fmu info` works without the extra. `cdpr fmu check` uses FMPy as well.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from xml.etree import ElementTree
from xml.etree.ElementTree import Element as Node

from cdpr.base.errors import FmuError
from cdpr.base.problems import printable
from cdpr.base.units import BASE_UNITS, Unit
from cdpr.fmu.read.model import Capabilities, ModelDescription, Variable

MAX_ELEMENTS = 1_000_000  # of one array: a thousand times the need of a robot, too few to fill the memory
MAX_REFERENCE = 2**32 - 1  # value references are 32 bit
KINDS_2 = ("Real", "Integer", "Boolean", "String", "Enumeration")
KINDS_3 = (
    "Float32", "Float64", "Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64",
    "Boolean", "String", "Binary", "Enumeration", "Clock",
)  # fmt: skip
FLOATS = ("Real", "Float32", "Float64")
TRUE = ("true", "1")
# Numbers as XML Schema writes them: ASCII digits, no underscores.
WHOLE = re.compile(r"\s*[+-]?[0-9]{1,20}\s*", re.ASCII)
REAL = re.compile(r"\s*[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?\s*", re.ASCII)
MAX_DIMENSIONS = 32
MAX_NAME = 1000  # characters of names and units: tables are as wide as the longest
# Name of a file in the archive, and of functions: other characters could lead out of the archive.
IDENTIFIER = re.compile(r"[A-Za-z_][A-Za-z0-9_]*", re.ASCII)


def read_description(content: bytes) -> ModelDescription:
    """Return the content of modelDescription.xml.

    Raises:
        FmuError: if it is invalid, or the FMU is not one for co-simulation in FMI 2.0 or 3.0.
    """
    root = parse(content, "modelDescription.xml")
    if root.tag != "fmiModelDescription":
        raise FmuError(f"modelDescription.xml: expected the root <fmiModelDescription>, got <{root.tag[:40]}>")
    version = root.get("fmiVersion", "")
    fmi = "2.0" if version == "2.0" else "3.0" if re.fullmatch(r"3\.0(\.[0-9]+)?", version) else None
    if fmi is None:
        raise FmuError(
            f"this is an FMU of FMI {version[:20] or 'without version'}; cdpr supports FMI 2.0 and 3.0: export it "
            "again for one of them"
        )
    interface = _interface(root, fmi)
    identifier = interface.get("modelIdentifier", "")
    if not IDENTIFIER.fullmatch(identifier):
        raise FmuError(
            f"modelDescription.xml: modelIdentifier {identifier[:60]!r} is not a C identifier (letters, digits, _); "
            "it names the library to load, so it could lead out of the archive"
        )
    units = {unit.name: unit for unit in map(_unit, root.iterfind("UnitDefinitions/Unit"))}
    types = _types(root, fmi)
    found = root.find("ModelVariables")
    nodes = [] if found is None else list(found)
    sizes = {_integer(node, "valueReference", None): node.get("start", "") for node in nodes if node.tag == "UInt64"}
    read = (_variable(node, fmi, types, units, sizes) for node in nodes)
    variables = [each for each in read if each is not None]
    _refuse_doubles(variables)
    experiment = root.find("DefaultExperiment")
    return ModelDescription(
        fmi=fmi,
        name=_text(root, "modelName"),
        token=root.get("guid" if fmi == "2.0" else "instantiationToken", ""),
        identifier=identifier,
        variables=tuple(variables),
        capabilities=_capabilities(interface, fmi),
        units=units,
        default_step=None if experiment is None else _number(experiment, "stepSize"),
        description=_text(root, "description"),
        tool=_text(root, "generationTool"),
    )


def read_terminals(content: bytes) -> tuple[dict[str, str], ...]:
    """Return the terminals of terminalsAndIcons.xml.

    Raises:
        FmuError: if it is invalid.
    """
    root = parse(content, "terminalsAndIcons.xml")
    return tuple(
        {_text(node, "memberName"): _text(node, "variableName") for node in terminal.iterfind("TerminalMemberVariable")}
        for terminal in root.iterfind("Terminals//Terminal")
    )


def parse(content: bytes, name: str) -> Node:
    """Parse XML without DOCTYPE, and therefore without entities.

    Raises:
        FmuError: if it is not such XML.
    """
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise FmuError(f"{name}: is not in UTF-8, as FMI demands (byte {error.start})") from None
    if "<!DOCTYPE" in text:
        raise FmuError(f"{name}: has a DOCTYPE, which can define entities; FMI does not need it, so it is rejected")
    try:
        # Parsed as text: the file cannot declare another encoding.
        return ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise FmuError(f"{name}: is not sound XML: {error}") from None
    except ValueError as error:  # a NUL, a lone surrogate
        raise FmuError(f"{name}: is not sound XML: {error}") from None


def _interface(root: Node, fmi: str) -> Node:
    node = root.find("CoSimulation")
    if node is not None:
        return node
    for other, words in (("ModelExchange", "Model Exchange"), ("ScheduledExecution", "Scheduled Execution")):
        if root.find(other) is not None:
            raise FmuError(
                f"this FMU (FMI {fmi}) is for {words} only, without a solver; cdpr supports "
                "Co-Simulation: export it again as such"
            )
    raise FmuError("modelDescription.xml: has no <CoSimulation>; cdpr supports Co-Simulation FMUs only")


def _capabilities(node: Node, fmi: str) -> Capabilities:
    state = "FMUstate" if fmi == "2.0" else "FMUState"
    return Capabilities(
        get_set_state=node.get(f"canGetAndSet{state}") in TRUE,
        serialize_state=node.get(f"canSerialize{state}") in TRUE,
        variable_step=node.get("canHandleVariableCommunicationStepSize") in TRUE,
        once_per_process=node.get("canBeInstantiatedOnlyOncePerProcess") in TRUE,
        needs_tool=node.get("needsExecutionTool") in TRUE,
        fixed_internal_step=_number(node, "fixedInternalStepSize"),
    )


def _unit(node: Node) -> Unit:
    name, base = _text(node, "name"), node.find("BaseUnit")
    if base is None:
        return Unit(name)
    factor, offset = _number(base, "factor"), _number(base, "offset")
    if factor == 0.0:
        raise FmuError(f"modelDescription.xml: the unit '{name}' has the factor 0")
    exponents = tuple(_integer(base, key, 0) for key in BASE_UNITS)
    return Unit(name, exponents, 1.0 if factor is None else factor, offset or 0.0)


def _types(root: Node, fmi: str) -> dict[str, Node]:
    """Return declared types that may have a unit, by name."""
    if fmi == "3.0":
        return {node.get("name", ""): node for node in root.iterfind("TypeDefinitions/*")}
    return {node.get("name", ""): node[0] for node in root.iterfind("TypeDefinitions/SimpleType") if len(node)}


def _variable(
    node: Node, fmi: str, types: dict[str, Node], units: dict[str, Unit], sizes: dict[int, str]
) -> Variable | None:
    """Read one variable; `sizes` are the start values, by value reference, of possible dimensions."""
    kinds = KINDS_2 if fmi == "2.0" else KINDS_3
    value = next((child for child in node if child.tag in kinds), None) if fmi == "2.0" else node
    if value is None or value.tag not in kinds:
        return None  # an annotation, or a kind of variable of a later version
    name = _text(node, "name")
    if not name:
        raise FmuError("modelDescription.xml: a variable has no name")
    reference = _integer(node, "valueReference", None)
    if not 0 <= reference <= MAX_REFERENCE:
        raise FmuError(f"modelDescription.xml: '{name}' has the invalid value reference {reference}")
    causality = node.get("causality", "local")
    fixed = causality.lower().endswith("parameter")
    natural = "fixed" if fixed and fmi == "3.0" else "continuous" if fmi == "2.0" or value.tag in FLOATS else "discrete"
    declared = types.get(value.get("declaredType", ""))
    given = [each for each in (value, declared) if each is not None]
    symbol = next((_text(each, "unit") for each in given if each.get("unit")), None) if value.tag in FLOATS else None
    start = value.get("start")
    variable = Variable(
        name=name,
        value_reference=reference,
        kind=value.tag,
        causality=_text(node, "causality", "local"),
        variability=_text(node, "variability", natural),
        shape=_shape(node, name, sizes),
        unit=None if symbol is None else units.get(symbol, Unit(symbol)),
        start=None if start is None else tuple(start.split()) if fmi == "3.0" else (start,),
        relative=any(each.get("relativeQuantity") in TRUE for each in given),
        aliases=tuple(_text(alias, "name") for alias in node.iterfind("Alias")),
        description=_text(node, "description"),
    )
    _check_start(variable)
    return variable


def _shape(node: Node, name: str, sizes: dict[int, str]) -> tuple[int, ...]:
    """Return the shape of a variable; a dimension is a number, or the start value of another variable."""
    shape = []
    for dimension in node.iterfind("Dimension"):
        if dimension.get("start") is not None:
            size = _integer(dimension, "start", None)
        else:
            start = sizes.get(_integer(dimension, "valueReference", None), "")
            if not WHOLE.fullmatch(start):
                raise FmuError(f"modelDescription.xml: a dimension of '{name}' has no size")
            size = int(start)
        shape.append(size)
    if len(shape) > MAX_DIMENSIONS or any(size < 1 for size in shape) or math.prod(shape) > MAX_ELEMENTS:
        shown = " x ".join(map(str, shape[:MAX_DIMENSIONS]))
        raise FmuError(f"modelDescription.xml: '{name}' is {shown}; expected 1 to {MAX_ELEMENTS} elements")
    return tuple(shape)


def _check_start(variable: Variable) -> None:
    sound = SOUND.get(variable.kind)
    if sound is None or variable.start is None:
        return
    if len(variable.start) != variable.size or not all(map(sound, variable.start)):
        shown = printable(" ".join(variable.start))[:60]
        what = "values" if variable.kind == "Boolean" else "numbers"
        raise FmuError(
            f"modelDescription.xml: '{variable.name}' starts with '{shown}'; expected {variable.size} {what}, "
            f"of the kind {variable.kind}"
        )


def _refuse_doubles(variables: list[Variable]) -> None:
    seen: set[str] = set()
    for variable in variables:
        if variable.name in seen:
            raise FmuError(f"modelDescription.xml: there are two variables '{variable.name}'")
        seen.add(variable.name)


def _text(node: Node, key: str, default: str = "") -> str:
    """Return a text without control characters."""
    text = node.get(key, default)
    if len(text) > MAX_NAME and key != "description":
        raise FmuError(f"modelDescription.xml: {_place(node)} has a {key} of {len(text)} letters, more than {MAX_NAME}")
    return printable(text)


def _integer(node: Node, key: str, default: int | None) -> int:
    text = node.get(key)
    if text is None and default is not None:
        return default
    if not WHOLE.fullmatch(text or ""):
        shown = None if text is None else text[:40]
        raise FmuError(f"modelDescription.xml: {_place(node)} needs a whole number as {key}, got {shown!r}")
    return int(text or "")


def _number(node: Node, key: str) -> float | None:
    text = node.get(key)
    if text is None:
        return None
    if not _finite(text):
        raise FmuError(f"modelDescription.xml: {_place(node)} needs a number as {key}, got {text[:40]!r}")
    return float(text)


def _finite(text: str) -> bool:
    """Return whether a text is a finite number of XML; Python would accept 1_0 and the digits of any script."""
    return REAL.fullmatch(text) is not None and math.isfinite(float(text))


def _place(node: Node) -> str:
    name = node.get("name")
    return f"<{node.tag}>" if name is None else f"<{node.tag} name={name[:60]!r}>"


# By kind, the check of one number of a start value; texts may be any.
SOUND: dict[str, Callable[[str], object]] = {
    **dict.fromkeys(FLOATS, _finite),
    **dict.fromkeys((kind for kind in (*KINDS_2, *KINDS_3) if "Int" in kind or kind == "Enumeration"), WHOLE.fullmatch),
    "Boolean": (*TRUE, "false", "0").__contains__,
}
