"""What the loop computes from each new state: the cable geometry, and whether the state can be true."""

from __future__ import annotations

import math

from cdpr.model.jit import kernel
from cdpr.model.kernels import cable_geometry, conjugate, logarithm, multiply, quaternion
from cdpr.model.robot import Array

# Faster than any cable robot by two orders: whoever gets there has diverged.
SPEED_MAX = 1e3  # m/s
ANGULAR_SPEED_MAX = 1e4  # rad/s

# Quaternions are renormalised by every engine each step; this is far above round-off, far below a usable attitude.
NORM_TOLERANCE = 1e-6

# A step of the pose may differ from the velocity after it by this many times the change of velocity, plus what
# round-off and attitude maps leave. Semi-implicit schemes need 0, any consistent scheme at most 1.
JUMP_FACTOR = 2.0
JUMP_SPEED = 1e-6  # m/s and rad/s

FAULTS = {
    1: "the state is not finite",
    2: "the attitude quaternion is not of unit length",
    3: "the platform moves absurdly fast",
    4: "the pose jumped, which its velocity does not explain; the engine may have reset itself",
    5: "a cable has no length",
}


@kernel
def observe(
    anchors: Array, period: float, arm: float, live: Array, state: Array, W: Array, length: Array, rate: Array
) -> int:
    """Write wrench matrix (6, m), lengths and rates (m,) at the state `live` (13,); return 0 or a key of FAULTS.

    `state` (13,) holds the state of one control `period` (s) ago and becomes a copy of `live`; `arm` (m) is the
    distance of the centre of mass from the origin, which lets the origin swing about it within a step.
    """
    fault = 0
    for i in range(13):
        if not math.isfinite(live[i]):
            fault = 1
    if fault == 0:
        q = quaternion(live, 3)
        if abs(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] - 1.0) > NORM_TOLERANCE:
            fault = 2
        speed, spin, jump, change, spin_change = 0.0, 0.0, 0.0, 0.0, 0.0
        turn = logarithm(multiply(q, conjugate(quaternion(state, 3))))
        twist = 0.0
        for i in range(3):
            v, w = live[7 + i], live[10 + i]
            speed += v * v
            spin += w * w
            jump += (live[i] - state[i] - period * v) ** 2
            change += (v - state[7 + i]) ** 2
            twist += (turn[i] - period * w) ** 2
            spin_change += (w - state[10 + i]) ** 2
        allowed = JUMP_FACTOR * math.sqrt(change) + JUMP_SPEED + period * spin * arm
        # A turn by more than pi comes back as its shorter twin: only smaller ones can be compared.
        spin_allowed = JUMP_FACTOR * math.sqrt(spin_change) + JUMP_SPEED + period * spin
        comparable = period * math.sqrt(spin) < 1.0
        if speed > SPEED_MAX * SPEED_MAX or spin > ANGULAR_SPEED_MAX * ANGULAR_SPEED_MAX:
            fault = 3
        elif math.sqrt(jump) > period * allowed or (comparable and math.sqrt(twist) > period * spin_allowed):
            fault = 4
        cable_geometry(anchors, live, W, length, rate)
        for i in range(anchors.shape[0]):
            if not length[i] > 0.0:
                fault = 5
    for i in range(13):
        state[i] = live[i]
    return fault
