"""Robots as plain data with the keys of a robot file, and documents of scenarios and robots given in Python.

Data from Python pass the same checks as files. Their problems name the key, without file and line.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import BaseModel

from cdpr.base.errors import CdprError, ScenarioError
from cdpr.base.files import seen_from
from cdpr.base.problems import Mark, dotted, shown
from cdpr.cables import MODELS, NUMBERS, TABLES
from cdpr.cables.elastic import DAMPING
from cdpr.config.document import Document
from cdpr.config.overrides import NotPlainError, plain_key, plain_value
from cdpr.config.yaml_text import dump
from cdpr.log.files import make_folder, output_path, replace
from cdpr.model import Cable, Robot, Winch
from cdpr.model.cable import TORQUE
from cdpr.model.robot import COMMANDED, DOF_NAMES, Array
from cdpr.model.shapes import Cylinder, Frame, Mesh, Shape
from cdpr.scenario import examples
from cdpr.scenario.appearance import FrameSection

HERE = Mark("")  # position of values given in Python

# Values that cables may share, in the order of robot files.
SHARED = ("diameter", "axial_stiffness", "damping", "linear_density", "exit")


def document_of(data: Mapping[str, Any], folder: str | None = None, *, study: bool = False) -> Document:
    """Return the document of a scenario's or robot's data; file names in it are relative to a folder.

    By default that is the present working folder, also if it changes later. A scenario's robot may be a Robot, and its
    name that of an example.

    Raises:
        ScenarioError: if a value is no plain data.
    """
    folder = working_folder() if folder is None else folder
    plain: dict[str, Any] = {}
    problems = []
    for key, value in data.items():
        try:
            plain[plain_key(key)] = plain_value(value, (key,))
        except NotPlainError as error:
            problems.append(f"{dotted(error.path)}{': ' if error.path else ''}{error}")
    if problems:
        raise ScenarioError(problems)
    robot = None if study else plain.get("robot")  # those of studies and designs are found like in their files
    if isinstance(robot, str) and robot and not os.path.exists(os.path.join(folder, robot)):
        if (file := examples.resolve(robot, "robot")) == robot:
            raise ScenarioError([f"robot: there is no file '{robot}'{examples.hint(robot, 'robot')}"])
        plain["robot"] = seen_from(folder, file)
    return Document(plain, "", folder, values={(): HERE})


def working_folder() -> str:
    """Return the working folder; "" if it was deleted."""
    try:
        return os.getcwd()
    except OSError:
        return ""


def robot_data(robot: Robot) -> dict[str, Any]:
    """Return a robot as plain data of a robot file, in world axes; without values equal to the defaults.

    The same bits are read back. The file of a mesh has its absolute name, which scenarios built in Python accept.

    Raises:
        ScenarioError: if a cable has an exit that robot files do not know.
    """
    platform = robot.platform
    xx, xy, xz, _, yy, yz, _, _, zz = platform.inertia.ravel().tolist()
    body: dict[str, Any] = {"mass": platform.mass, "inertia": [xx, yy, zz, xy, xz, yz]}
    if platform.center_of_mass.any():
        body["center_of_mass"] = platform.center_of_mass.tolist()
    if platform.shape is not None:
        body["shape"] = _shape(platform.shape)
    if platform.colour is not None:
        body["colour"] = platform.colour
    if platform.tools:
        body["tools"] = {name: point.tolist() for name, point in platform.tools.items()}
    data: dict[str, Any] = {"name": robot.name}
    if robot.dof != DOF_NAMES:
        data["dof"] = list(robot.dof)
    if not robot.unilateral:
        data["unilateral"] = False
    limits = {"min": robot.tension_min.tolist(), "max": robot.tension_max.tolist()}
    data["platform"] = body
    data["tension"] = {key: values[0] if len(set(values)) == 1 else values for key, values in limits.items()}
    if robot.frame is not None:
        data["frame"] = _frame(robot.frame)
    if robot.home is not None:
        data["home"] = _pose(robot.home)
    return data | _cables(robot)


def save_robot(robot: Robot, path: str | os.PathLike[str]) -> None:
    """Write a robot as YAML; see `Robot.save`."""
    target = output_file(path)
    write(target, dump(data_for(robot, target.parent)))


def data_for(robot: Robot, folder: str | os.PathLike[str]) -> dict[str, Any]:
    """Return the data of a robot file in a folder."""
    data = robot_data(robot)
    shape = data["platform"].get("shape", {})
    if "mesh" in shape:
        shape["mesh"] = seen_from(folder, shape["mesh"])
    return data


def output_file(path: str | os.PathLike[str]) -> Path:
    """Return the path of a YAML file to write; raise CdprError for another name."""
    if not isinstance(path, str | os.PathLike) or Path(path).suffix not in (".yaml", ".yml"):
        raise CdprError(f"save(path=): expected the name of a file that ends in .yaml, got {shown(path)}")
    return output_path(path, "save(path=)")


def write(target: Path, text: str) -> None:
    """Write a file, and its folder if it is missing."""
    make_folder(target.parent)
    replace(target, text)


def _cables(robot: Robot) -> dict[str, Any]:
    """Return cables and their common values."""
    rows = [_cable(robot, cable) for cable in robot.cables]
    common: dict[str, Any] = {} if robot.cable_model == COMMANDED else {"model": robot.cable_model}
    for key in (*SHARED, "winch"):
        values = [row.get(key) for row in rows]
        if values[0] is not None and all(value == values[0] for value in values):
            common[key] = values[0]
            for row in rows:
                del row[key]
    winch = common.pop("winch", None)
    data: dict[str, Any] = {"cable": common} if common else {}
    return data | ({} if winch is None else {"winch": winch}) | {"cables": rows}


def _cable(robot: Robot, cable: Cable) -> dict[str, Any]:
    row: dict[str, Any] = {"name": cable.name, "frame": cable.frame.tolist(), "platform": cable.platform.tolist()}
    length = {"min": cable.length_min, "max": cable.length_max}
    row["length"] = {key: value for key, value in length.items() if value is not None} or None
    row["speed_max"] = cable.speed_max
    row["model"] = cable.model
    row |= {key: getattr(cable, key) for key in SHARED[:-1]}
    row |= {key: value for key, value in cable.own.items() if not NUMBERS[f"cable.{key}"].table}
    row |= {key: [list(each) for each in table.rows(cable.own)] or None for key, table in TABLES.items()}
    chain = MODELS.get(cable.model or robot.cable_model)  # None for an unknown one, which the checks report
    if not cable.damping and (chain is None or DAMPING not in chain.numbers):
        row["damping"] = None
    row["winch"] = None if cable.winch is None else _winch(cable.winch)
    if cable.exit is not None and not isinstance(cable.exit, BaseModel):
        text = f"expected an exit such as cdpr.cables.Pulley, got an object of {type(cable.exit).__name__}"
        raise ScenarioError([f"cables.{cable.name}.exit: {text}"])
    row["exit"] = None if cable.exit is None else cable.exit.model_dump(mode="json", exclude_none=True)
    return {key: value for key, value in row.items() if value is not None}


def _winch(winch: Winch) -> dict[str, Any]:
    values = {each.name: getattr(winch, each.name) for each in fields(winch) if each.name not in ("own", "type")}
    given = {key: value for key, value in values.items() if not math.isnan(value)} | dict(winch.own)
    return given if winch.type == TORQUE else {"type": winch.type} | given


def _shape(shape: Shape) -> dict[str, Any]:
    if isinstance(shape, Cylinder):
        return {"cylinder": {"radius": shape.radius, "height": shape.height}}
    return {"mesh": os.path.abspath(shape.file)} if isinstance(shape, Mesh) else shape.outline


def _frame(frame: Frame) -> dict[str, Any]:
    corners = frame.edges.reshape(-1, 3)
    box = {"lower": corners.min(axis=0).tolist(), "upper": corners.max(axis=0).tolist()}
    colour = {} if frame.colour is None else {"colour": frame.colour}
    section = {"shape": "posts" if len(frame.edges) == 4 else "box", **box, **colour}
    read = FrameSection(**section).build(corners)
    return section if np.array_equal(read.edges, frame.edges) else {"edges": frame.edges.tolist(), **colour}


def _pose(pose: Array) -> dict[str, Any]:
    """Return the section of a home."""
    q = pose[3:].tolist()
    turned = (
        {}
        if q == [1.0, 0.0, 0.0, 0.0] and not np.signbit(q).any()
        else {"orientation": {"quaternion": _unscaled(pose[3:])}}
    )
    return {"position": pose[:3].tolist(), **turned}


def _unscaled(q: Array) -> Sequence[float]:
    """Return numbers that are exactly `q` when a file's reader divides them by their norm, which rounds."""
    for step in range(4096):
        found = q * (1.0 + step * 1e-9)
        if np.array_equal(found / np.linalg.norm(found), q):
            break
    else:
        found = q
    numbers: list[float] = found.tolist()
    return numbers
