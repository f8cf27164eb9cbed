"""Random MJCF robots of many files and bodies, compared with MuJoCo's own evaluation of the whole model.

`CDPR_MJCF=400 pytest tests/formats/test_import_mjcf_variants.py` tries 400 of them.
"""

from __future__ import annotations

import os

import numpy as np
import pytest

import cdpr
from cdpr.formats import import_file
from cdpr.formats.read.import_files import write
from cdpr.mechanics.kinematics import lengths, make_state, wrench_matrix
from cdpr.model import rotations

mujoco = pytest.importorskip("mujoco")

COUNT = int(os.environ.get("CDPR_MJCF", "5"))
SAME = 1e-11  # relative and absolute, m, N and kg m^2 for robots of some metres: round-off of turned frames
FAR = 1e9  # a control beyond all ranges, so that the force is at its limit
FINGERS = (
    '<body name="finger_a" pos="0.1 0 -0.1"><joint name="a" type="slide" axis="1 0 0" range="0 0.1"/>'
    '<geom type="box" size="0.02 0.03 0.1" mass="0.3"/></body><body name="finger_b" pos="-0.1 0 -0.1">'
    '<joint name="b" type="hinge" axis="0 1 0"/><geom size="0.05" mass="0.2"/></body>'
)
TABLE = (
    '<body name="box_a" pos="1 1 0"><freejoint/><geom size="0.1"/></body>'
    '<body name="box_b" pos="1 2 0"><joint name="door"/><geom size="0.1"/></body>'
)


class Variant:
    """Files of a random model, and what is unambiguous about them."""

    def __init__(self, seed, folder):
        rng = self.rng = np.random.default_rng(seed)
        self.cables = int(rng.integers(1, 9))
        self.gripper, self.others, self.site, self.key, self.split = (bool(rng.integers(2)) for _ in range(5))
        self.servos = 0
        masts = "".join(self.nested(f"m{k}", f'<site name="f{k}" pos="{self.numbers(size=3)}"/>') for k in range(8))
        ends = "".join(self.nested(f"p{k}", f'<site name="b{k}" pos="{self.numbers(size=0.3)}"/>') for k in range(8))
        load = (
            f'<body name="load" pos="{self.numbers()}" quat="{self.numbers(4)}"><freejoint/>'
            f'<geom type="box" size="0.3 0.2 0.1" pos="{self.numbers(size=0.1)}" euler="10 20 30" mass="5"/>'
            + (f'<site name="platform" pos="{self.numbers(size=0.2)}" quat="{self.numbers(4)}"/>' if self.site else "")
            + f"{ends}{FINGERS if self.gripper else ''}</body>"
        )
        world, table = f"{masts}{load}", TABLE if self.others else ""
        if self.split:
            (folder / "parts").mkdir()
            (folder / "parts" / "masts.xml").write_text(
                f"<mujocoinclude><worldbody>{world}</worldbody></mujocoinclude>"
            )
            world, include = "", '<include file="parts/masts.xml"/>'
        else:
            include = ""
        equal = '<joint joint1="a" joint2="b"/>' if self.gripper else ""
        equal += '<connect body1="box_a" body2="box_b" anchor="0 0 0"/>' if self.others else ""
        actuators = "".join(self.actuator(k) for k in rng.permutation(self.cables))
        if self.gripper:
            actuators += '<position name="grip" joint="a" kp="10"/>'
        self.path = folder / "model.xml"
        self.path.write_text(
            f'<mujoco model="variant"><compiler angle="degree"/>{include}'
            f"<worldbody>{world}{table}</worldbody><equality>{equal}</equality>"
            f"<tendon>{''.join(self.tendon(k) for k in range(self.cables))}</tendon><actuator>{actuators}</actuator>"
            + (f'<keyframe><key name="k" qpos="{self.qpos()}"/></keyframe>' if self.key else "")
            + "</mujoco>"
        )

    def numbers(self, count=3, size=1.0):
        return " ".join(map(repr, (size * self.rng.normal(size=count)).tolist()))

    def nested(self, name, inside):
        """A body in a body in a frame, each turned, at random depth."""
        for k in range(self.rng.integers(3)):
            place = f'pos="{self.numbers(size=0.2)}" quat="{self.numbers(4)}"'
            inside = f'<body name="{name}_{k}" {place}>{inside}</body>'
        return f'<frame euler="{self.numbers(size=90)}">{inside}</frame>' if self.rng.integers(2) else inside

    def tendon(self, k):
        force = f' actuatorfrcrange="{self.pull(40, 90)}"' if self.rng.integers(4) == 0 else ""
        length = ' range="0.5 30"' if self.rng.integers(3) == 0 else ""
        sites = [f'<site site="f{k}"/>', f'<site site="b{k}"/>'][:: 1 - 2 * int(self.rng.integers(2))]
        return f'<spatial name="t{k}"{force}{length}>{"".join(sites)}</spatial>'

    def pull(self, low, high):
        """A range of forces that pull, or of both senses, so wide that every gear leaves some tension."""
        return f"{-self.rng.uniform(low, high)!r} {self.rng.uniform(low, high)!r}"

    def actuator(self, k):
        rng, gear = self.rng, float(self.rng.choice([-3.0, -1.0, -0.5, 1.0, 2.0]))
        force = f'forcerange="{self.pull(10, 100)}"'
        kind = str(rng.choice(["motor", "general", "position", "velocity"]))
        about = f'name="a{k}" tendon="t{k}" gear="{gear}"'
        if kind == "motor":
            return f'<motor {about} ctrlrange="{self.pull(5, 50)}" {force if rng.integers(2) else ""}/>'
        if kind == "general" and rng.integers(2):
            gain = float(rng.choice([-7.0, 0.3, 12.0]))
            limit = f'forcelimited="true" {force}' if rng.integers(2) else f'forcelimited="false" {force}'
            return f'<general {about} gainprm="{gain}" ctrllimited="true" ctrlrange="{self.pull(5, 50)}" {limit}/>'
        self.servos += 1
        if kind == "general":
            return f'<general {about} gainprm="50" biastype="affine" biasprm="0 -50 -5" {force}/>'
        limit = ' ctrlrange="-2 20"' if rng.integers(2) else ""
        return f'<{kind} {about} {"kp" if kind == "position" else "kv"}="90" {force}{limit}/>'

    def qpos(self):
        """Platform, fingers where they are at first, free box, door: in the order of the bodies."""
        load = self.numbers(7)
        fingers = " 0 0" if self.gripper else ""
        return f"{load}{fingers}{' 1 1 0 1 0 0 0 0' if self.others else ''}"


def platform_of(data, variant):
    frame = data.site("platform") if variant.site else data.body("load")
    return frame.xpos.copy(), frame.xmat.reshape(3, 3).copy()


def reach(model, data, clamped):
    """Lowest and highest tension of each actuator at the pose of `data`, at controls beyond all ranges."""
    model.opt.disableflags = 0 if clamped else int(mujoco.mjtDisableBit.mjDSBL_CLAMPCTRL)
    forces = []
    for control in (-FAR, FAR):
        data.ctrl[:] = control
        mujoco.mj_forward(model, data)
        forces.append(-model.actuator_gear[:, 0] * data.actuator_force)
    return np.sort(forces, axis=0)


@pytest.mark.parametrize("seed", range(COUNT))
def test_a_random_model_is_what_mujoco_makes_of_it(tmp_path, seed):
    variant = Variant(seed, tmp_path)
    found = import_file(variant.path)
    robot = cdpr.load_robot(write(found, tmp_path / "out", force=True)[0])
    model = mujoco.MjModel.from_xml_path(str(variant.path))
    data = mujoco.MjData(model)
    if variant.key:
        mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    place, turn = platform_of(data, variant)
    assert np.allclose(robot.home[:3], place, atol=SAME)
    assert np.allclose(rotations.matrix(robot.home[3:]), turn, atol=SAME)

    pulled = [k for k in range(model.nu) if model.actuator_trntype[k] == mujoco.mjtTrn.mjTRN_TENDON]
    tendons = model.actuator_trnid[pulled, 0]
    first = int(model.body("load").dofadr[0])
    begin = int(model.jnt_qposadr[model.body("load").jntadr[0]])
    for _ in range(3):
        q = variant.rng.normal(size=4)
        data.qpos[begin : begin + 7] = [*variant.rng.normal(size=3), *(q / np.linalg.norm(q))]
        data.qvel[:] = 0.0
        mujoco.mj_forward(model, data)
        place, turn = platform_of(data, variant)
        state = make_state(place, rotations.from_matrix(turn))
        assert np.allclose(lengths(robot, state), data.ten_length[tendons], atol=SAME)

        # The rate of a length is that of its wrench's power: of the body's origin, and in the body's axes.
        data.ctrl[:] = 0.0
        body, axes = data.body("load").xpos, data.body("load").xmat.reshape(3, 3)
        W = wrench_matrix(robot, state)
        moments = W[3:] + np.cross(place - body, W[:3].T).T
        rates = np.vstack([-W[:3], -axes.T @ moments])
        arms = moment_arms(model, data)[pulled][:, first : first + 6] / model.actuator_gear[pulled, :1]
        assert np.allclose(rates.T, arms, atol=SAME)

        whole = mass_matrix(model, data)[first : first + 6, first : first + 6]
        offset = axes.T @ (place + turn @ robot.platform.center_of_mass - body)
        shift = robot.platform.mass * (offset @ offset * np.eye(3) - np.outer(offset, offset))
        inertia = axes.T @ turn @ robot.platform.inertia @ turn.T @ axes
        assert np.allclose(whole[0, 0], robot.platform.mass, rtol=SAME)
        assert np.allclose(whole[3:, 3:], inertia + shift, atol=SAME)

    servo = model.actuator_biastype[pulled] != mujoco.mjtBias.mjBIAS_NONE
    low, high = np.where(servo, reach(model, data, False)[:, pulled], reach(model, data, True)[:, pulled])
    assert np.allclose(robot.tension_min, low, rtol=SAME, atol=SAME)
    assert np.allclose(robot.tension_max, high, rtol=SAME, atol=SAME)
    assert robot.unilateral == bool((low >= 0.0).all())
    ranges = model.tendon_range[tendons]
    for cable, (short, long), limited in zip(robot.cables, ranges, model.tendon_limited[tendons], strict=True):
        if limited:
            assert (cable.length_min, cable.length_max) == (short, long)

    said = "\n".join([*found.warnings, *found.left_out])
    assert ("tendons have servos" in said) == bool(servo.any()) == bool(variant.servos)
    assert ("'finger_a' moves on its own" in said) == variant.gripper
    assert ("'box_a' moves on its own" in said) == variant.others


def mass_matrix(model, data):
    rows = np.zeros((model.nv, model.nv))
    for row, unit in zip(rows, np.eye(model.nv), strict=True):
        mujoco.mj_mulM(model, data, row, unit)
    return rows


def moment_arms(model, data):
    """The dense matrix (nu, nv) of MuJoCo's sparse one."""
    dense = np.zeros((model.nu, model.nv))
    mujoco.mju_sparse2dense(
        dense, data.actuator_moment.reshape(-1), data.moment_rownnz, data.moment_rowadr, data.moment_colind.reshape(-1)
    )
    return dense
