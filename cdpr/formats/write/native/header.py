"""Header of a real-time controller: its kernels, structure and C interface."""

from __future__ import annotations

import re
from collections.abc import Mapping
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path

import numpy as np

from cdpr.cables import commands_of, takes_lengths
from cdpr.fmu.export import Control
from cdpr.fmu.export.winch_variables import UNITS, prescribed
from cdpr.formats.write.native.layout import Layout
from cdpr.model import Robot
from cdpr.native.entries import headers_of, listing, own_entries

TEMPLATE = Path(__file__).parent / "files" / "robot.h.in"
INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([\w/.]+)[>"].*\n', re.MULTILINE)
ONCE = re.compile(r"^\s*#\s*pragma once\n", re.MULTILINE)
VITAL = ("IGNORED", "ANSWER", "FINITE", "ESTIMATE")  # in the order of cdpr/calls.hpp
# Of controllers that command rates, or lengths by ideal drives or steppers.
MEASURE = """
#define CDPR_MEASURE 1 /* this controller needs measured unwound lengths */

/* Take the measured unwound lengths of the cables (CDPR_CABLES), m; call it before each cdpr_step. Without it, all
   commanded rates are 0. */
int cdpr_measure(cdpr_robot* robot, const double unwound[CDPR_CABLES]);
"""
MEASURED = """
extern "C" int cdpr_measure(cdpr_robot* robot, const double* unwound) {
    using namespace cdpr;
    if (!robot || !unwound || !all_finite(unwound, CDPR_CABLES)) return CDPR_BAD_INPUT;
    if (robot->ready != exported::pipeline.signature) return CDPR_NOT_READY;
    const ExportedMemory parts(exported::pipeline, robot->memory);
    memcpy(parts.number(@UNWOUND@), unwound, CDPR_CABLES * sizeof *unwound);
    return CDPR_OK;
}
"""
EXIT_KIND = 6  # column of `lines`, where exits are not all points


def header_text(control: Control, layout: Layout) -> tuple[str, int]:
    """Return the header of a controller, and the signature of its structure."""
    own, entries = own_entries(control.own)
    includes, expressions = listing(control.pipeline.names, entries)
    start = "\n".join(["#include <cdpr/entry.hpp>", "#include <cdpr/realtime.hpp>", *includes]) + "\n"
    headers = {name: text.decode() for name, text in own.items()}
    headers |= {name: text.decode() for name, text in headers_of([start, *headers.values()]).items()}
    words = {
        "ROBOT": control.robot.name,
        "NAMES": " with solver ".join(control.names),
        "VERSION": version("cdpr"),
        "OUTPUT": _output(control),
        "ANSWERS": "commands" if takes_lengths(control.robot) else "tensions",
        "UNITS": _units(control.robot),
        "MEASURE": MEASURE if prescribed(control.robot) else "",
        "MEASURED": _measured(layout) if prescribed(control.robot) else "",
        "CABLES": ", ".join(cable.name for cable in control.robot.cables),
        "STEP": repr(control.control_step),
        "M": str(control.robot.m),
        "FILE_BYTES": str(layout.file_bytes),
        "MEMORY": str(layout.memory_words),
        "KERNELS": flattened(start, headers),
        **_structure(layout, expressions),
    }
    text = _filled(TEMPLATE.read_text(encoding="utf-8"), words)
    signature = int.from_bytes(sha256(f"{text}{_exit_kinds(control)}".encode()).digest()[:8], "little")
    return _filled(text, {"SIGNATURE": f"{signature:#x}"}), signature


def _output(control: Control) -> str:
    """Return the name of the output, with its units if they differ from N."""
    if not takes_lengths(control.robot):
        return "tension" if len(control.names) > 1 else "command"
    return f"command of the winches (tension in N, unwound length in m, or its rate in m/s: {_units(control.robot)})"


def _units(robot: Robot) -> str:
    """Return the unit of the commands, or those of all cables."""
    units = [UNITS[each] for each in commands_of(robot)]
    return units[0] if len(set(units)) == 1 else ", ".join(units)


def _measured(layout: Layout) -> str:
    return MEASURED.replace("@UNWOUND@", str(layout.places["unwound"]))


def flattened(text: str, headers: Mapping[str, str]) -> str:
    """Return a C++ text with each of these headers in place of the first line that includes it."""
    known: set[str] = set()

    def replaced(match: re.Match[str]) -> str:
        name = match[1]
        if name not in headers:
            return match[0]
        if name in known:
            return ""
        known.add(name)
        return INCLUDE.sub(replaced, ONCE.sub("", headers[name]))

    return INCLUDE.sub(replaced, text)


def _filled(template: str, words: Mapping[str, str]) -> str:
    return re.sub(r"@(\w+)@", lambda match: words.get(match[1], match[0]), template)


def _structure(layout: Layout, expressions: Mapping[str, str]) -> dict[str, str]:
    calls = [
        f"    {{{expressions[call.name]}, {first}, {str(call.in_order).lower()}, {VITAL[call.vital]}, {call.skip}, "
        f"{call.repair}}},"
        for call, first in layout.calls
    ]
    members = [f"    {{MemberKind::{kind}, {value}u}}," for kind, value in layout.members]
    counts = {
        "CALL_COUNT": len(calls),
        "MEMBER_COUNT": len(members),
        "INTEGER_COUNT": len(layout.integers),
        "NUMBER_COUNT": len(layout.numbers),
        "WORK_COUNT": layout.work,
    }
    places = {name.upper(): layout.places[name] for name in ("state", "desired", "tension", "report")}
    places["TENSION"] = layout.places.get("winch_command", places["TENSION"])
    return {
        "CALLS": "\n".join(calls),
        "MEMBERS": "\n".join(members),
        "INTEGERS": ", ".join(map(str, layout.integers)) or "0",
        **{name: str(value) for name, value in {**counts, **places}.items()},
    }


def _exit_kinds(control: Control) -> list[float]:
    """Return the kinds of the cables' exits, which select the code of kernels; data files must agree in them."""
    lines = next(array.content for array in control.pipeline.arrays if array.name == "lines")
    table = np.asarray(lines)
    return table[:, EXIT_KIND].tolist() if table.shape[1] > EXIT_KIND else []
