"""Computed-torque control in task space."""

from __future__ import annotations

from cdpr_controllers.law import GainLaw


class ComputedTorque(GainLaw):
    """Inverse dynamics of the desired acceleration with proportional and damping terms.

    wrench = M a + C(omega) - G with a = a_d + kd (v_d - v) + kp (x_d - x), linear and angular. The error then follows
    e'' + kd e' + kp e = 0. See thesis 6.3 to 6.5. Equation 6.5 there contradicts 6.1 and 6.2: it prints a_d - v instead
    of v_d - v in the damping term, and a minus in front. All omit the velocity-dependent terms and a centre of mass off
    the origin.
    """

    operation = "computed_torque"
