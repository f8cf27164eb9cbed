"""Cables of exported FMUs: lines and chains as arrays of the kernels, and the linked variables."""

from __future__ import annotations

import math

from cdpr.cables import chain_of, takes_lengths
from cdpr.cables.chain import Number, Part
from cdpr.cables.tables import (
    CHAIN_WIDTH,
    HOME,
    SPAN,
    TRANSMISSION,
    WINCH,
    chain_table,
    command_kinds,
    home_lengths,
    line_table,
    places_of_states,
)
from cdpr.cables.transmission import COULOMB_SPEED, EFFICIENCY, GROWTH, KERNEL
from cdpr.fmu.export.variables import Variable, parameter
from cdpr.model import Cable, Robot
from cdpr.native.exported_pipeline import ExportedPipeline, Link

NAN = math.nan
HOME_LENGTH = "winch.home_length"
HOME_TEXT = "length of each cable at the home pose, at which its drum has the drum_radius; change it with the anchors"


def given_numbers(part: Part, cable: Cable) -> dict[Number, float]:
    """Return the numbers of a part that a cable has: not those that it need not have, and no infinite limits."""
    values = {number: number.of(cable, part.without.get(number.name)) for number in part.numbers}
    lacking = [number for number in part.numbers if number.name in part.without and math.isnan(number.of(cable, NAN))]
    return {number: value for number, value in values.items() if number not in lacking and math.isfinite(value)}


def parameters_of(robot: Robot, cable: Cable) -> dict[int, tuple[Number, float]]:
    """Return the parameters of a cable with their values, by their columns in `chain_table`.

    Numbers of the transmission are parameters only if the robot uses them.
    """
    chain = chain_of(robot, cable)
    found: dict[int, tuple[Number, float]] = {}
    for part, first in ((chain.winch, WINCH), (chain.span, SPAN)):
        own = given_numbers(part, cable)
        found |= {place: (number, own[number]) for place, number in enumerate(part.numbers, first) if number in own}
    given = {number: {number.of(each, number.default) for each in robot.cables} for number in chain.winch.transmission}
    accepted = {number for number, values in given.items() if values != {number.default}}
    if EFFICIENCY in accepted:
        accepted.add(COULOMB_SPEED)
    places = enumerate(KERNEL, TRANSMISSION)
    return found | {place: (number, number.of(cable)) for place, number in places if number in accepted}


def winch_parameters(robot: Robot) -> list[Variable]:
    """Return the parameters of winches and spans, 0 for cables without them."""
    found = [dict(parameters_of(robot, cable).values()) for cable in robot.cables]
    homes = [parameter(HOME_LENGTH, (robot.m,), "m", home_lengths(robot), HOME_TEXT, least=0.0)]
    return [
        parameter(
            number.name,
            (robot.m,),
            number.unit_of_fmu,
            [own.get(number, 0.0) for own in found],
            number.text,
            least=0.0 if number.positive else None,
        )
        for number in dict.fromkeys(number for own in found for number in own)
    ] + (homes if _grows(robot) else [])


def _grows(robot: Robot) -> bool:
    """Return True if the radius of some drum depends on the unwound length."""
    return any(GROWTH in dict(parameters_of(robot, cable).values()) for cable in robot.cables)


def add_lines(pipeline: ExportedPipeline, robot: Robot) -> None:
    """Add the anchors and exits of the cables, and link the variables of the anchors."""
    index = pipeline.find("lines")
    table = line_table(robot)
    if index is None:
        index = pipeline.add("lines", table, "memory")
    for i in range(robot.m):
        place = i * table.shape[1]
        pipeline.links.append(Link("frame_anchors", 3 * i, 3, index, place))
        pipeline.links.append(Link("platform_anchors", 3 * i, 3, index, place + 3))


def add_chains(pipeline: ExportedPipeline, robot: Robot) -> None:
    """Add the winches and spans of the cables, and link their variables."""
    index = pipeline.add("chains", chain_table(robot), "memory")
    pipeline.add("winch_places", places_of_states(robot), "constant")
    add_commands(pipeline, robot)
    for i, cable in enumerate(robot.cables):
        for place, (number, _) in parameters_of(robot, cable).items():
            pipeline.links.append(Link(number.name, i, 1, index, i * CHAIN_WIDTH + place, positive=number.positive))
        if _grows(robot):
            pipeline.links.append(Link(HOME_LENGTH, i, 1, index, i * CHAIN_WIDTH + HOME))


def add_commands(pipeline: ExportedPipeline, robot: Robot) -> None:
    """Add the quantities that the winches take, unless all take tensions."""
    if takes_lengths(robot):
        pipeline.add("takes", command_kinds(robot), "constant")


def states_in(pipeline: ExportedPipeline) -> int:
    """Return the number of states of the winches of a pipeline, 0 without winches."""
    index = pipeline.find("winch_places")
    return 0 if index is None else int(pipeline.arrays[index].content[-1])


def width_of(robot: Robot) -> int:
    """Return the number of columns of the lines."""
    return int(line_table(robot).shape[1])
