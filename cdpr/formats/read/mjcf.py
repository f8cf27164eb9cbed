"""Reader of MJCF, MuJoCo's format: one body on spatial tendons, each with a motor.

MuJoCo's compiler resolves defaults, angles, frames and inertias; poses are from its kinematics. The platform's origin
and axes are those of the body's site `platform` if present, otherwise the body's own. If the body rotates about a ball
or hinge joint, the origin is the joint's anchor. A tendon force is positive when it pushes: for a motor with control c,
gear g and gain k, the tension is -g k c.
"""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from cdpr.formats.read.import_options import Choice
from cdpr.formats.read.imported import Imported, slug
from cdpr.formats.read.inertia import six
from cdpr.formats.read.mjcf_bodies import Bodies
from cdpr.formats.read.mjcf_body import Body, tidy
from cdpr.formats.read.mjcf_cables import Cables
from cdpr.formats.read.mjcf_files import include
from cdpr.formats.read.mjcf_text import Lines, checked, compiled, text_of
from cdpr.formats.read.mjcf_used import idle, mark
from cdpr.formats.read.xml import parse, root_of
from cdpr.model import rotations
from cdpr.scenario.schema import World

ROUND = 1e-14  # relative to the trace: smaller tensor entries are round-off of rotations


def recognise(content: bytes) -> bool:
    """Return True if the content is an MJCF model or a part of one."""
    return root_of(content)[0] in ("mujoco", "mujocoinclude")


def is_main_file(path: Path, content: bytes) -> bool:
    """Return True if a robot is read from this file; included parts are not read alone."""
    return root_of(content)[0] == "mujoco"


def load_library() -> None:
    """Import MuJoCo if it is installed."""
    with suppress(ImportError):
        import mujoco  # noqa: F401


def read(path: Path, content: bytes, choice: Choice) -> Imported:
    """Read a robot.

    Raises:
        FormatError: if the model is invalid or not representable.
        PluginError: if MuJoCo is missing.
    """
    root = parse(content, str(path))
    if root.name != "mujoco":
        raise root.wrong("it is a part that other files include: import the file that does")
    included = include(root, path)
    lines = checked(root)
    bodies = Bodies(lines)
    mujoco, model = _compiled(lines, bodies)
    body = Body(mujoco, model, lines)
    cables = Cables(mujoco, model, lines, body, bodies.dropped, choice.tension)
    name = slug(root.attributes.get("model", ""), slug(path.stem, "robot"))
    found = Imported(
        name, f"MJCF: {path.name}, compiled by MuJoCo {mujoco.__version__}", {"name": name}, [root, *included]
    )
    found.left_out = lines.left_out
    at = f"of body '{body.name}', line {body.element.line}"
    found.robot |= {
        "dof": list(body.dof),
        **({} if cables.pull else {"unilateral": False}),
        "platform": _platform(body) | ({"tools": cables.tools} if cables.tools else {}),
        "tension": cables.tension,
        "home": _home(body),
        **cables.sections,
        "cables": cables.rows,
    }
    found.comments = {
        ("dof",): f"joints {', '.join(body.joints)} {at}",
        ("platform", "mass"): f"kg, {at}",
        ("platform", "inertia"): "kg m^2 about the centre of mass, as MuJoCo's compiler has it",
        ("home",): body.begins,
        ("cables",): f"m; sites of tendons; origin and axes of the platform: {body.origin}",
        **({("platform", "tools"): "m, other sites of the body"} if cables.tools else {}),
        **cables.comments,
    }
    found.warnings = lines.warnings + cables.warnings
    for each in (root, *included):
        mark(each)
        lines.left_out += idle(each)
    _options(model, mujoco, lines)
    return found


def _compiled(lines: Lines, bodies: Bodies) -> tuple[ModuleType, Any]:
    """Return MuJoCo and its model without fixed bodies' joints; the first keyframe is reduced to the platform."""
    key = lines.find("key", lines.first("key").attributes.get("name", ""))
    if bodies.platform is not None and bodies.dropped and key is not None and "qpos" in key.attributes:
        mujoco, whole = compiled(text_of(lines, set()), lines)
        body = whole.body(bodies.platform.attributes["name"])
        joints = range(int(body.jntadr[0]), int(body.jntadr[0]) + int(body.jntnum[0]))
        sizes = {mujoco.mjtJoint.mjJNT_FREE: 7, mujoco.mjtJoint.mjJNT_BALL: 4}
        count = sum(sizes.get(mujoco.mjtJoint(whole.jnt_type[joint]), 1) for joint in joints)
        first = int(whole.jnt_qposadr[joints[0]])
        lines.qpos = " ".join(repr(float(value)) for value in whole.key_qpos[0][first : first + count])
    return compiled(text_of(lines, bodies.dropped), lines)


def _platform(body: Body) -> dict[str, Any]:
    inertia = np.where(np.abs(body.inertia) < ROUND * np.trace(body.inertia), 0.0, body.inertia)
    given: dict[str, Any] = {"mass": tidy([body.mass])[0], "inertia": tidy(six(inertia), np.trace(inertia))}
    if any(centre := tidy(body.centre, body.size)):
        given["center_of_mass"] = centre
    if (shape := body.shape()) is not None:
        given |= shape
    return given


def _home(body: Body) -> dict[str, Any]:
    q = tidy(rotations.from_matrix(body.home[1]), 1.0)
    turned = {} if q == [1.0, 0.0, 0.0, 0.0] else {"orientation": {"quaternion": q}}
    return {"position": tidy(body.home[0], body.size), **turned}


def _options(model: Any, mujoco: Any, lines: Lines) -> None:
    """Report options that belong to a scenario or are not supported."""
    usual = list(World().gravity)
    weightless = model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_GRAVITY
    gravity = [0.0, 0.0, 0.0] if weightless else model.opt.gravity.tolist()
    if gravity != usual:
        text = f"gravity {gravity}: set world.gravity in scenarios; the default is {usual} m/s^2"
        lines.left_out.append(f"{lines.first('option').at}: {text}")
    if model.opt.density or model.opt.viscosity:
        lines.left_out.append(f"{lines.first('option').at}: density, viscosity: not supported")
