"""The same motion as scenarios/caroca.yaml by a plain script: MuJoCo, numpy, quadprog and a CSV file, without cdpr.

What a good user writes for one robot, and makes fast: arrays made once, no package that is not needed, rows written at
the end. It checks nothing, knows one cable model and one motion, and ends with a traceback. quadprog is under the GPL,
and comes with the extra `test`. Run: python benchmarks/script.py [SECONDS [FILE]]; start.py times it beside cdpr.
"""

from __future__ import annotations

import sys
from math import cos, sin

import mujoco
import numpy as np
from quadprog import solve_qp

STEP, RISE = 0.001, 3.0  # s: of control and physics, and of the motion
START, END, YAW = np.array([0.0, 0.0, 1.2]), np.array([1.5, 0.5, 1.6]), 0.3
MASS, INERTIA = 150.0, np.array([6.5, 20.0, 22.5])
KP, KD, LOW, HIGH = 100.0, 20.0, 50.0, 10000.0
GRAVITY = np.array([0.0, 0.0, -9.81])
X, Y = 3.5, 2.0
FRAME = np.array([[sx * X, sy * Y, 3.5] for sy in (-1, 1) for sx in (-1, -1, 1, 1)])
BODY = np.array(
    [
        [0.6, -0.3, -0.2],
        [-0.6, 0.3, 0.2],
        [-0.6, -0.3, 0.2],
        [0.6, 0.3, -0.2],
        [-0.6, -0.3, -0.2],
        [0.6, 0.3, 0.2],
        [0.6, -0.3, 0.2],
        [-0.6, 0.3, -0.2],
    ]
)
MODEL = f"""
<mujoco>
  <option timestep="{STEP}" integrator="Euler" gravity="0 0 -9.81"/>
  <worldbody>
    <body name="platform" pos="0 0 1.2">
      <freejoint/>
      <inertial pos="0 0 0" mass="{MASS}" diaginertia="6.5 20 22.5"/>
    </body>
  </worldbody>
</mujoco>
"""


def desired(t: float) -> tuple[float, float, float]:
    """Share of the way, its rate and acceleration: a quintic from rest to rest."""
    s = min(t / RISE, 1.0)
    if s == 1.0:
        return 1.0, 0.0, 0.0
    return (
        s**3 * (10.0 - 15.0 * s + 6.0 * s * s),
        30.0 * s * s * (1.0 - s) ** 2 / RISE,
        60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / RISE**2,
    )


def simulate(seconds: float) -> np.ndarray:
    """Rows of time, position, quaternion, desired position and tensions."""
    model = mujoco.MjModel.from_xml_string(MODEL)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    steps = round(seconds / STEP)
    rows = np.empty((steps + 1, 19))
    way, turn, rotation = END - START, np.empty(3), np.empty(9)
    goal, error, wrench = np.empty(4), np.empty(4), np.empty(6)
    wrench_matrix, identity, zero = np.empty((8, 6)), np.eye(8), np.zeros(8)
    constraints, bounds = np.hstack([np.empty((8, 6)), np.eye(8), -np.eye(8)]), np.full(22, LOW)
    bounds[14:] = -HIGH
    position, quaternion, velocity, spin = data.qpos[:3], data.qpos[3:], data.qvel[:3], data.qvel[3:]
    force = data.xfrc_applied[1]
    for k in range(steps + 1):
        t = k * STEP
        share, rate, acceleration = desired(t)
        mujoco.mju_quat2Mat(rotation, quaternion)
        matrix = rotation.reshape(3, 3)
        omega = matrix @ spin
        goal[:] = cos(0.5 * YAW * share), 0.0, 0.0, sin(0.5 * YAW * share)
        mujoco.mju_negQuat(error, quaternion)
        mujoco.mju_mulQuat(error, goal, error)
        mujoco.mju_quat2Vel(turn, error, 1.0)
        where = START + share * way
        linear = acceleration * way + KD * (rate * way - velocity) + KP * (where - position)
        angular = KP * turn - KD * omega
        angular[2] += (acceleration + KD * rate) * YAW
        inertia = matrix * INERTIA @ matrix.T
        momentum = inertia @ omega
        wrench[:3] = MASS * (linear - GRAVITY)
        wrench[3:] = inertia @ angular
        wrench[3] += omega[1] * momentum[2] - omega[2] * momentum[1]
        wrench[4] += omega[2] * momentum[0] - omega[0] * momentum[2]
        wrench[5] += omega[0] * momentum[1] - omega[1] * momentum[0]
        arm = BODY @ matrix.T
        cable = FRAME - position - arm
        cable /= np.sqrt(np.einsum("ij,ij->i", cable, cable))[:, None]
        wrench_matrix[:, :3] = cable
        wrench_matrix[:, 3] = arm[:, 1] * cable[:, 2] - arm[:, 2] * cable[:, 1]
        wrench_matrix[:, 4] = arm[:, 2] * cable[:, 0] - arm[:, 0] * cable[:, 2]
        wrench_matrix[:, 5] = arm[:, 0] * cable[:, 1] - arm[:, 1] * cable[:, 0]
        constraints[:, :6], bounds[:6] = wrench_matrix, wrench
        tension = solve_qp(identity, zero, constraints, bounds, 6)[0]
        row = rows[k]
        row[0], row[1:4], row[4:8], row[8:11], row[11:] = t, position, quaternion, where, tension
        force[:] = tension @ wrench_matrix
        mujoco.mj_step(model, data)
    return rows


if __name__ == "__main__":
    found = simulate(float(sys.argv[1]) if len(sys.argv) > 1 else 4.0)
    if len(sys.argv) > 2:
        line = ",".join(["%.9g"] * found.shape[1]) + "\n"
        with open(sys.argv[2], "w") as file:
            file.writelines(line % tuple(row) for row in found.tolist())
    far = np.linalg.norm(found[:, 1:4] - found[:, 8:11], axis=1).max()
    print(f"{len(found)} samples; position error max {1e3 * far:.4g} mm; tension max {found[:, 11:].max():.5g} N")
