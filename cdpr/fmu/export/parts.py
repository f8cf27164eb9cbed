"""Cables of exported FMUs: lines and chains as arrays of the kernels, and the linked variables."""

from __future__ import annotations

from collections.abc import Sequence

from cdpr.cables import chain_of
from cdpr.cables.chain import Number, Part
from cdpr.cables.tables import CHAIN_WIDTH, SPAN, WINCH, chain_table, line_table, places_of_states
from cdpr.fmu.export.variables import Variable, parameter
from cdpr.model import Robot
from cdpr.native.exported_pipeline import ExportedPipeline, Link


def numbers_of(parts: Sequence[Part]) -> list[Number]:
    """Return the parameters of these parts, each once."""
    return list({number.name: number for part in parts for number in part.numbers}.values())


def winch_parameters(robot: Robot) -> list[Variable]:
    """Return the parameters of winches and spans, 0 for cables without them."""
    parts = [(chain.winch, chain.span) for chain in (chain_of(robot, cable) for cable in robot.cables)]
    return [
        parameter(
            number.name,
            (robot.m,),
            number.unit_of_fmu,
            [
                number.of(cable) if any(number in part.numbers for part in own) else 0.0
                for cable, own in zip(robot.cables, parts, strict=True)
            ],
            number.text,
            least=0.0 if number.positive else None,
        )
        for number in numbers_of([part for own in parts for part in own])
    ]


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
    for i, cable in enumerate(robot.cables):
        chain = chain_of(robot, cable)
        for part, first in ((chain.winch, WINCH), (chain.span, SPAN)):
            for k, number in enumerate(part.numbers):
                place = i * CHAIN_WIDTH + first + k
                pipeline.links.append(Link(number.name, i, 1, index, place, positive=number.positive))


def states_in(pipeline: ExportedPipeline) -> int:
    """Return the number of states of the winches of a pipeline, 0 without winches."""
    index = pipeline.find("winch_places")
    return 0 if index is None else int(pipeline.arrays[index].content[-1])


def width_of(robot: Robot) -> int:
    """Return the number of columns of the lines."""
    return int(line_table(robot).shape[1])
