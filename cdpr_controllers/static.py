"""Static control: gravity compensation with proportional and damping terms."""

from __future__ import annotations

from cdpr_controllers.law import GainLaw


class Static(GainLaw):
    """Gravity compensation at the current pose with proportional and damping terms towards the desired state.

    wrench = M (kd (v_d - v) + kp (x_d - x)) - G. Without desired acceleration and velocity-dependent terms, the
    platform lags behind a moving target. With both gains zero, the law is pure statics. (The code of the thesis uses
    gains of 50.)
    """

    operation = "static"
