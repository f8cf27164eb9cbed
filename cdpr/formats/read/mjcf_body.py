"""Moving body of an MJCF model: degrees of freedom, inertia and initial pose."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from cdpr.formats.read.mjcf_text import Lines
from cdpr.formats.read.xml import Element
from cdpr.model.robot import DOF_NAMES, Array

SITE = "platform"
ALONG = 1e-9  # sine of the largest angle between a joint axis and a world axis: files are rounded
NEAR = 1e-9  # m
# Digits of tidied numbers, and the round-off of rotating back and forth: closer numbers are those in the file.
DIGITS, TURNED = 12, 4e-15
GREY = "#808080"  # default colour of geoms


def tidy(values: Sequence[float] | Array, size: float = 0.0) -> list[float]:
    """Return numbers without the round-off of rotations; `size` is the magnitude of the numbers computed with them."""
    short = [float(f"{value:.{DIGITS}g}") for value in values]
    pairs = zip(short, values, strict=True)
    return [(a if abs(a - b) <= TURNED * max(size, abs(b)) else float(b)) + 0.0 for a, b in pairs]


class Body:
    """The moving body and everything that is fixed to it.

    Attributes:
        number: its id in the compiled model.
        name: its name.
        element: its element in the file.
        dof: directions of motion, along and about the world axes.
        joints: kinds of its joints.
        origin: description of the platform's origin.
        begins: description of the source of the home pose.
        mass: kg.
        centre: (3,), centre of mass, m, platform axes.
        inertia: (3, 3), about the centre of mass, kg m^2, platform axes.
        home: position (3,), m, and rotation (3, 3).
        size: size of the robot, at most 1, m.
    """

    def __init__(self, mujoco: Any, model: Any, lines: Lines) -> None:
        self._mujoco, self._model, self._lines = mujoco, model, lines
        number = self._only_one()
        self.number, self.name = number, self._name(number)
        self.element = lines.of("body", self.name)
        if (pictured := self._pictured()) is not None:
            owner, geom = pictured
            raise geom.wrong(f"body '{owner}' takes its inertia from a mesh: give it <inertial>")
        self._data = mujoco.MjData(model)
        kinds = [mujoco.mjtJoint(model.jnt_type[j]) for j in self._own_joints()]
        self.joints = [kind.name.removeprefix("mjJNT_").lower() for kind in kinds]
        q = model.qpos0.copy()
        if self.joints == ["free"]:
            q[:] = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)  # free of round-off
        self._move(q)
        self.dof = self._directions()
        place, axes = self._frame()
        self.mass, self.centre, self.inertia = self._inertia(place, axes)
        self._place, self._axes = place, axes
        at, R = self._data.xpos[number].copy(), self._rotation(number)
        self._shift, self._turn = R.T @ (place - at), R.T @ axes
        self.begins = "the pose of the model file"
        self._fixed = self._data.site_xpos.copy()
        self.size = min(1.0, float(np.abs([*self._fixed, place, self.centre]).max()))
        self._fixed_geoms = self._data.geom_xpos.copy(), self._data.geom_xmat.copy().reshape(-1, 3, 3)
        if model.nkey:
            self.begins = f"keyframe '{model.key(0).name}'"
        self._move(model.key_qpos[0] if model.nkey else model.qpos0)
        R = self._rotation(number)
        self.home = self._data.xpos[number] + R @ self._shift, R @ self._turn
        self._report_omitted()

    def moves(self, site: int) -> bool:
        """Return True if a site is on the body."""
        return self._is_part(self._model.site_bodyid[site])

    def place(self, site: int) -> Array:
        """Return the position of a site, (3,), m: in platform axes on the platform, otherwise in the world."""
        at = np.asarray(self._fixed[site])
        return np.asarray(self._axes.T @ (at - self._place)) if self.moves(site) else at

    def shape(self) -> dict[str, Any] | None:
        """Return the platform's shape and colour; report shapes that are not supported."""
        model, kinds = self._model, self._mujoco.mjtGeom
        geoms = [k for k in range(model.ngeom) if self._is_part(model.geom_bodyid[k])]
        if not geoms:
            return None
        known = {kinds.mjGEOM_BOX: "box", kinds.mjGEOM_SPHERE: "sphere", kinds.mjGEOM_CYLINDER: "cylinder"}
        kind = known.get(kinds(model.geom_type[geoms[0]]))
        far = np.abs(self._fixed_geoms[0][geoms[0]] - self._place).max()
        turned = np.abs(self._fixed_geoms[1][geoms[0]] - self._axes).max()
        if len(geoms) > 1 or kind is None or far > NEAR or (turned > NEAR and kind != "sphere"):
            text = f"geoms of body '{self.name}': one box, sphere or cylinder in the middle of a platform is drawn"
            self._lines.left_out.append(f"{self.element.at}: {text}")
            return None
        size = model.geom_size[geoms[0]].tolist()
        sizes = {"box": [2.0 * x for x in size], "sphere": size[0]}
        shape = sizes.get(kind, {"radius": size[0], "height": 2.0 * size[1]})
        colour = "#" + "".join(f"{round(float(part) * 255):02x}" for part in model.geom_rgba[geoms[0], :3])
        return {"shape": {kind: shape}, **({} if colour == GREY else {"colour": colour})}

    def _only_one(self) -> int:
        model = self._model
        moving = [k for k in range(1, model.nbody) if model.body_dofnum[k]]
        if not moving:
            raise self._lines.root.wrong("no moving body: expected a platform with a joint, such as <freejoint/>")
        if len(moving) > 1:
            first, second = self._name(moving[0]), self._name(moving[1])
            text = f"body '{second}' is a second moving body, besides '{first}'; only robots with one platform"
            raise self._lines.of("body", second).wrong(f"{text} can be described here")
        return moving[0]

    def _directions(self) -> tuple[str, ...]:
        """Return the free directions of the joints.

        Raises:
            FormatError: if guides of cdpr do not support them.
        """
        if self.joints == ["free"]:
            return DOF_NAMES
        if self.joints == ["ball"]:
            return DOF_NAMES[3:]
        found: list[str] = []
        for joint, kind in zip(self._own_joints(), self.joints, strict=True):
            axis, at = self._data.xaxis[joint], self._joint(joint)
            along = int(np.argmax(np.abs(axis)))
            if kind not in ("slide", "hinge"):
                raise at.wrong(f"a {kind} joint besides others: no equivalent guide")
            if np.abs(np.delete(axis, along)).max() > ALONG:
                raise at.wrong(f"axis: expected x, y or z of the world, got {axis.tolist()}")
            if any(name.startswith("r") for name in found):
                text = "expected slides before one hinge; for a free body, use <freejoint/>"
                raise at.wrong(f"this {kind} turns with the hinge before it: {text}")
            name = ("r" if kind == "hinge" else "") + "xyz"[along]
            if name in found:
                raise at.wrong(f"a second {kind} along {name}")
            found.append(name)
        return tuple(name for name in DOF_NAMES if name in found)

    def _frame(self) -> tuple[Array, Array]:
        """Return origin (3,) and axes (3, 3) of the platform at MuJoCo's reference configuration."""
        model, data, joints = self._model, self._data, self._own_joints()
        site = self._mujoco.mj_name2id(model, self._mujoco.mjtObj.mjOBJ_SITE, SITE)
        named = site >= 0 and self.moves(site)
        place, axes = data.xpos[self.number].copy(), self._rotation(self.number)
        self.origin = f"body '{self.name}'"
        if named:
            place, axes = data.site_xpos[site].copy(), data.site_xmat[site].reshape(3, 3).copy()
            self.origin = f"site '{SITE}', line {self._lines.of('site', SITE).line}"
        if self.joints[-1] in ("ball", "hinge"):
            anchor, axis = data.xanchor[joints[-1]].copy(), data.xaxis[joints[-1]]
            away = place - anchor
            if np.linalg.norm(away if self.joints[-1] == "ball" else np.cross(axis, away)) > NEAR:
                place = anchor
                self.origin = f"the {self.joints[-1]} of body '{self.name}'"
        # With slides and a hinge, the axes equal the world's in the reference configuration.
        return place, axes if self.joints in (["free"], ["ball"]) else np.eye(3)

    def _inertia(self, place: Array, axes: Array) -> tuple[float, Array, Array]:
        model, data = self._model, self._data
        parts = [k for k in range(1, model.nbody) if self._is_part(k)]
        mass = float(sum(model.body_mass[k] for k in parts))
        if not 0.0 < mass < np.inf:
            raise self.element.wrong(
                f"body '{self.name}': expected <inertial> or geoms that give a mass, got {mass:g} kg",
            )
        if not all(np.isfinite(each[parts]).all() for each in (model.body_inertia, data.xipos, data.ximat)):
            raise self.element.wrong(f"body '{self.name}': its inertia is not finite: its sizes are too large")
        centre = sum(model.body_mass[k] * data.xipos[k] for k in parts) / mass
        whole = np.zeros((3, 3))
        for k in parts:
            R, r = data.ximat[k].reshape(3, 3), data.xipos[k] - centre
            whole += R @ np.diag(model.body_inertia[k]) @ R.T
            whole += model.body_mass[k] * (r @ r * np.eye(3) - np.outer(r, r))
        whole = axes.T @ whole @ axes
        return mass, np.asarray(axes.T @ (centre - place)), np.asarray((whole + whole.T) / 2)

    def _pictured(self) -> tuple[str, Element] | None:
        """Return a part whose inertia would come from a skipped mesh, with its geom; None if there is none."""
        explicit = self._lines.explicit()
        names = [self._name(k) for k in range(1, self._model.nbody) if self._is_part(k)]
        found = (n for n in names if n in self._lines.pictured and n not in explicit)
        return next(((n, self._lines.pictured[n]) for n in found), None)

    def _report_omitted(self) -> None:
        """Report properties of joints and bodies that are not imported."""
        model = self._model
        for joint in self._own_joints():
            dofs = model.dof_jntid == joint
            effects = {
                "damping": model.dof_damping[dofs],
                "armature": model.dof_armature[dofs],
                "frictionloss": model.dof_frictionloss[dofs],
                "stiffness": model.jnt_stiffness[joint],
                "range": model.jnt_limited[joint],
            }
            for word, value in effects.items():
                if np.any(value):
                    self._lines.left_out.append(f"{self._joint(joint).at}: {word} of a joint: not supported by guides")
        if np.any(model.body_gravcomp[[k for k in range(model.nbody) if self._is_part(k)]]):
            self._lines.left_out.append(f"{self.element.at}: gravcomp: not supported")

    def _move(self, q: Array) -> None:
        self._data.qpos[:] = q
        self._mujoco.mj_kinematics(self._model, self._data)

    def _rotation(self, body: int) -> Array:
        return np.array(self._data.xmat[body].reshape(3, 3))

    def _own_joints(self) -> list[int]:
        first = int(self._model.body_jntadr[self.number])
        return list(range(first, first + int(self._model.body_jntnum[self.number])))

    def _is_part(self, body: int) -> bool:
        return bool(self._model.body_weldid[body] == self.number)

    def _name(self, body: int) -> str:
        return str(self._model.body(body).name)

    def _joint(self, joint: int) -> Element:
        own = [each for each in self.element.children if each.name in ("joint", "freejoint")]
        at = joint - self._own_joints()[0]
        return own[at] if at < len(own) else self.element
