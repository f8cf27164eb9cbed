"""The parts of cables that exported FMUs know, those with C beside them, and the C file that lists them."""

from __future__ import annotations

from collections.abc import Sequence

from cdpr.cables import EXITS, MODELS, chain_of
from cdpr.cables.chain import Chain, Number, Part, Span, Winch
from cdpr.cables.exit import Exit
from cdpr.cables.twin import in_c, name_in_c, source
from cdpr.errors import CdprError
from cdpr.model import Cable, Robot


def exits() -> list[type[Exit]]:
    """Return the exits with C; here and below, their kind in an FMU is their place, from 1."""
    return [kind for kind in EXITS if in_c(kind.kernels)]


def winches() -> list[Winch]:
    """Return the winches with C."""
    return [part for part in dict.fromkeys(chain.winch for chain in MODELS.values()) if in_c(part.kernels)]


def spans() -> list[Span]:
    """Return the spans with C; one that does not stretch needs none, and has the kind 0. None that bends is known."""
    parts = dict.fromkeys(chain.span for chain in MODELS.values() if not chain.span.bends)
    return [part for part in parts if in_c(part.kernels)]


def numbers_of(parts: Sequence[Part]) -> list[Number]:
    """Return the numbers that parts take, each once."""
    return list({number.name: number for part in parts for number in part.numbers}.values())


def exit_kind(cable: Cable) -> float:
    """Return the kind of what a cable leaves the frame by, 0 for an anchor; CdprError where it has no C."""
    if not isinstance(cable.exit, Exit) or not cable.exit.kernels:
        return 0.0
    if type(cable.exit) not in exits():
        raise _no_c(cable, f"exit {cable.exit.type}", cable.exit.kernels, "give the cable another exit")
    return 1.0 + exits().index(type(cable.exit))


def chain_kinds(robot: Robot, cable: Cable) -> tuple[float, float]:
    """Return the kinds of winch and span of a cable; CdprError where one has no C."""
    chain = chain_of(robot, cable)
    return _kind(robot, cable, chain, chain.winch, winches()), _kind(robot, cable, chain, chain.span, spans())


def _kind(robot: Robot, cable: Cable, chain: Chain, part: Part, known: Sequence[Part]) -> float:
    if not part.kernels:
        return 0.0
    if part not in known:
        which = "winch" if part is chain.winch else "span"
        remedy = "choose another cable.model, or export without winches"
        raise _no_c(cable, f"{which} of model {cable.model or robot.cable_model}", part.kernels, remedy)
    return 1.0 + known.index(part)


def _no_c(cable: Cable, what: str, kernels: str, remedy: str) -> CdprError:
    return CdprError(
        f"cable '{cable.name}': the {what} has no C ({source(kernels).name} beside its kernels), so it cannot be "
        f"exported: {remedy}"
    )


def part_sources() -> dict[str, bytes]:
    """Return the C files of all parts by their names, and the table of them, parts.c."""
    kernels = [*(kind.kernels for kind in exits()), *(part.kernels for part in (*winches(), *spans()))]
    files = [source(each) for each in kernels]
    return {**{path.name: path.read_bytes() for path in files}, "parts.c": part_table().encode()}


def part_table() -> str:
    """Return the C file that lists the functions and numbers of all parts."""
    numbers = numbers_of([*winches(), *spans()])
    places = {number.name: place for place, number in enumerate(numbers)}

    def taken(part: Part) -> str:
        return f"{{{len(part.numbers)}, {{{', '.join(str(places[number.name]) for number in part.numbers) or '0'}}}}}"

    prototypes, rows = [], {"Exit": ["{NULL, NULL}"], "Winch": ["{.held = NULL}"], "Span": ["{.pull = NULL}"]}
    for kind in exits():
        name = name_in_c(kind.kernels)
        prototypes.append(f"Leave {name}_leave;\nCarry {name}_carry;")
        rows["Exit"].append(f"{{{name}_leave, {name}_carry}}")
    for winch in winches():
        name = name_in_c(winch.kernels)
        prototypes.append(f"Hold {name}_held;\nTurn {name}_turn;")
        rows["Winch"].append(f"{{{name}_held, {name}_turn, {str(winch.immediate).lower()}, {taken(winch)}}}")
    for span in spans():
        name = name_in_c(span.kernels)
        prototypes.append(f"Pull {name}_pull;\nRest {name}_rest;")
        rows["Span"].append(f"{{{name}_pull, {name}_rest, {taken(span)}}}")
    rows["Number"] = [
        f'{{"{number.name}", "{number.unit_of_fmu}", {str(number.positive).lower()}}}' for number in numbers
    ] or ["{NULL, NULL, false}"]
    tables = zip(rows.items(), ("ALL_EXITS", "ALL_WINCHES", "ALL_SPANS", "ALL_NUMBERS"), strict=True)
    listed = [f"const {kind} {table}[] = {{\n    " + ",\n    ".join(lines) + ",\n};" for (kind, lines), table in tables]
    kinds = f"EXIT_KINDS = {len(exits())}, WINCH_KINDS = {len(winches())}, SPAN_KINDS = {len(spans())}"
    count = f"const size_t {kinds}, NUMBER_COUNT = {len(numbers)};"
    head = "/* Written by the exporter. SPDX-License-Identifier: Apache-2.0 */"
    return "\n".join([head, '#include "parts.h"\n', *prototypes, "", *listed, count, ""])
