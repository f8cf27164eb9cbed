"""Description of an FMU as text, and its signals as YAML for a scenario."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import Any

import yaml

from cdpr.fmu.read.archive import Archive
from cdpr.fmu.read.mapping import Mapping
from cdpr.fmu.read.model import Element
from cdpr.fmu.read.options import FMU, Source
from cdpr.fmu.read.ports import Port
from cdpr.fmu.read.signals import INPUTS, OUTPUTS, Role, Signal
from cdpr.ui.report.text.aligned import row, table, wrapped

SHOWN = ("input", "output", "parameter", "structuralParameter")  # other causalities matter only to the FMU's author


def lines(figures: dict[str, Any]) -> Iterator[str]:
    """Yield the result of `cdpr.fmu.read.describe.describe` as text."""
    yield f"{figures['file']}: {figures['name']}, FMI {figures['fmi']} co-simulation"
    for name, key in (("description", "description"), ("made by", "tool"), ("sha256", "sha256")):
        if figures[key]:
            yield from wrapped(row(name, figures[key]), 23)
    yield row("trusted", "yes, on your list" if figures["trusted"] else "no: pin the sha256, or 'cdpr fmu trust' it")
    platforms = ", ".join(figures["platforms"]) or "none"
    here = "runs on this machine" if figures["runs_here"] else "does not run on this machine"
    yield row("binaries", f"{platforms} ({here}); sources {'inside' if figures['sources'] else 'not inside'}")
    yield from wrapped(row("can", ", ".join(_abilities(figures["capabilities"])) or "fixed steps only"), 23)
    if figures["default_step_s"] is not None:
        yield row("step by default", f"{1e3 * figures['default_step_s']:g} ms")
    for causality in SHOWN:
        rows = _group([each for each in figures["variables"] if each["causality"] == causality])
        if rows:
            yield f"  {causality}s" if causality != "structuralParameter" else "  structural parameters"
            yield from (f"  {line}" for line in table(rows, left=5))


def _abilities(capabilities: dict[str, Any]) -> Iterator[str]:
    for key, words in (
        ("get_set_state", "save and restore its state"),
        ("serialize_state", "write its state to bytes"),
        ("variable_step", "take steps of any length"),
        ("once_per_process", "one instance per process"),
        ("needs_tool", "requires the tool that made it"),
    ):
        if capabilities[key]:
            yield words
    if capabilities["fixed_internal_step"] is not None:
        yield f"step by multiples of {1e3 * capabilities['fixed_internal_step']:g} ms"


def _group(variables: list[dict[str, Any]]) -> list[list[str]]:
    """Return one row per variable; array elements of FMI 2, which differ only in bracketed indices, share a row."""
    rows: list[list[str]] = []
    last: tuple[str, str] | None = None
    first = ""
    for each in variables:
        base = re.sub(r"\[[\d,]+\]$", "", each["name"])
        unit = each["unit"] or ""
        family = (base, each["kind"]) if base != each["name"] else None
        if family is not None and family == last:
            number = each["name"][len(base) :]
            rows[-1][0] = f"{base}{first} ... {number}"
            rows[-1][2] = rows[-1][2] if unit in rows[-1][2].split(", ") else f"{rows[-1][2]}, {unit}"
            rows[-1][3] = _cut(f"{rows[-1][3]} {' '.join(each['start'] or [])}".rstrip())
            continue
        last, first = family, each["name"][len(base) :]
        shape = " x ".join(map(str, each["shape"]))
        kind = each["kind"] + (f" ({shape})" if shape else "")
        rows.append([each["name"], kind, unit, _cut(" ".join(each["start"] or [])), _cut(each["description"], 60)])
    return rows


def _cut(text: str, width: int = 32) -> str:
    return text if len(text) <= width else text[: width - 4].rsplit(" ", 1)[0].removesuffix(" ...") + " ..."


PLACES: dict[Role, tuple[str, ...]] = {  # location of such an FMU in a scenario
    "plant": ("backend_options", FMU),
    "winch": ("actuators",),
    "controller": ("controller",),
}


def yaml_lines(archive: Archive, mapping: Mapping) -> Iterator[str]:
    """Yield the part of a scenario with the signals found; missing signals are comments."""
    indent = ""
    if mapping.role == "plant":
        yield "simulation:"
        yield f"  backend: {FMU}"
    for key in PLACES[mapping.role]:
        yield f"{indent}{key}:"
        indent += "  "
    if mapping.role == "controller":
        yield f"{indent}type: {FMU}"
    yield f"{indent}file: {_yaml_line(str(archive.path))}  # from the folder of the scenario"
    yield f"{indent}sha256: {archive.sha256}"
    yield f"{indent}signals:"
    for side, signals, ports in (
        ("inputs", INPUTS[mapping.role], mapping.inputs.ports),
        ("outputs", OUTPUTS[mapping.role], mapping.outputs.ports),
    ):
        yield f"{indent}  {side}:" + ("" if ports else " {}")
        chosen = any(signal.need == "choice" and signal.name in ports for signal in signals)
        for signal in signals:
            if signal.name in ports or not (chosen and signal.need == "choice"):
                yield f"{indent}    {_signal(signal, ports.get(signal.name))}"
    for notice in mapping.notices:
        yield f"# {notice}"


def _signal(signal: Signal, port: Port | None) -> str:
    if port is None:
        word = {"required": "needed", "choice": "this or another is needed", "optional": "not needed"}[signal.need]
        return f"# {signal.name}:  # not found; {word}"
    key = signal.name.replace("quaternion", "euler") if port.euler else signal.name
    value: Any = _variables(port.elements)
    source = port.source or Source(variable="")
    data = {"unit": source.unit, "order": port.euler or None, "factor": source.factor if source.factor != 1.0 else None}
    if given := {name: each for name, each in data.items() if each is not None}:
        value = {"variable": value, **given}
    units = ", ".join(dict.fromkeys(port.units))
    return f"{key}: {_yaml_line(value)}  # {len(port.elements)} numbers, {units}; by {port.rule}"


def _yaml_line(value: Any) -> str:
    """Return `value` as YAML on one line."""
    return (
        yaml.safe_dump(value, default_flow_style=True, width=10**6, allow_unicode=True).removesuffix("\n...\n").strip()
    )


def _variables(elements: Sequence[Element]) -> str | list[str]:
    """Return the elements as an array name, a pattern or a list of names."""
    variable = elements[0].variable
    if tuple(elements) == variable.elements:
        return variable.name
    names = [element.name for element in elements]
    for match in re.finditer(r"[01]", names[0]):
        head, tail, first = names[0][: match.start()], names[0][match.end() :], int(match[0])
        if names == [f"{head}{first + i}{tail}" for i in range(len(names))]:
            return head + ("{i}" if first else "{i0}") + tail
    return names
