"""The figures by which a run is judged at a glance."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from cdpr.model.robot import Array

if TYPE_CHECKING:
    from cdpr.log.run import Run


def summarise(run: Run) -> dict[str, Any]:
    """Return errors, tensions, infeasible steps and speed of a run as plain numbers.

    Errors are norms over the sample's three components; `largest_step` is the largest change of one tension from one
    sample to the next.
    """
    samples = len(run.rows)
    simulated = float(run.time[-1]) if samples else 0.0
    figures: dict[str, Any] = {
        "status": run.status,
        "samples": samples,
        "simulated_s": simulated,
        "infeasible_steps": int(np.count_nonzero(run.solver_status)),
    }
    if samples:
        with np.errstate(over="ignore", invalid="ignore"):  # a diverged run is summed up too
            tension = run.tension
            steps = np.abs(np.diff(tension, axis=0))
            figures["position_error_m"] = _error(run.position_error)
            figures["orientation_error_rad"] = _error(run.orientation_error)
            figures["tension_N"] = {
                "min": float(tension.min()),
                "max": float(tension.max()),
                "largest_step": float(steps.max()) if len(steps) else 0.0,
            }
            figures["residual_max_N"] = float(run.residual.max())
            figures["margin_min_N"] = float(run.margin.min())
    loop = run.timings.get("loop_s")
    if loop:
        figures["real_time_factor"] = simulated / loop
    return figures


def _error(components: Array) -> dict[str, float]:
    norms = np.linalg.norm(components, axis=1)
    return {"max": float(norms.max()), "rms": float(np.sqrt(np.mean(norms**2))), "final": float(norms[-1])}
