"""min sum (t_i / s_i)^2 subject to W t = wrench, where s_i is the strength of cable i."""

import numpy as np

from cdpr.plugins import TensionSolver
from cdpr.tension import Status


class Weighted(TensionSolver):
    """t = S (W S)^+ wrench with S = diag(t_max ^ power)."""

    def solve(self, W, wrench, t_min, t_max, tension):
        """Write the tensions into `tension` and return a status."""
        if not (np.isfinite(W).all() and np.isfinite(wrench).all()):
            return Status.BAD_INPUT
        strength = (t_max / t_max.max()) ** self.options.power
        tension[:] = strength * (np.linalg.pinv(W * strength, rcond=1e-9) @ wrench)
        balanced = np.allclose(W @ tension, wrench, rtol=0.0, atol=1e-9 * max(1.0, np.abs(wrench).max()))
        return Status.OK if balanced else Status.NOT_FOUND
