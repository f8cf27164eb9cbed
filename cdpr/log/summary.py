"""The figures by which a run is judged at a glance."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from cdpr.model.robot import Array

if TYPE_CHECKING:
    from cdpr.log.run import Run

# Energy counts as balanced where what no work explains is below this share of what was turned over: engines of first
# order reach a thousandth at their usual steps, and damping or a wrong mass that matters is above it.
BALANCED = 0.01


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
            if run.header.cable_model != "ideal":
                felt = run.cable_tension
                figures["cable_tension_N"] = {"min": float(felt.min()), "max": float(felt.max())}
            figures["residual_max_N"] = float(run.residual.max())
            figures["margin_min_N"] = float(run.margin.min())
            figures["energy_J"] = _energy(run)
    loop = run.timings.get("loop_s")
    if loop:
        figures["real_time_factor"] = simulated / loop
    return figures


def _error(components: Array) -> dict[str, float]:
    norms = np.linalg.norm(components, axis=1)
    return {"max": float(norms.max()), "rms": float(np.sqrt(np.mean(norms**2))), "final": float(norms[-1])}


def _energy(run: Run) -> dict[str, float | bool]:
    """Largest kinetic energy, works, and the largest residual of their balance beside the energy turned over.

    That is the largest of kinetic energy, change of potential energy and works at any time; less than a micro-joule is
    round-off at rest and counts as balanced.
    """
    change = run.potential - run.potential[0]
    parts = np.abs([run.kinetic, change, run.cable_work, run.external_work])
    turned_over, residual = float(parts.max()), float(np.abs(run.energy_residual).max())
    return {
        "kinetic_max": float(run.kinetic.max()),
        "cable_work": float(run.cable_work[-1]),
        "external_work": float(run.external_work[-1]),
        "turned_over": turned_over,
        "residual_max": residual,
        "balanced": residual <= max(BALANCED * turned_over, 1e-6),
    }
