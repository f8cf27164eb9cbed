"""Time of tension solvers of the C++ library, against the numba kernels that they replace.

As kernels.py, at one pose of a robot with 8 cables and six degrees of freedom: with wrenches that the middle of the
limits balances, and that the closed form does not. Run: python benchmarks/solver_kernels.py [NAME ...].
"""

from __future__ import annotations

import sys
from importlib import import_module
from typing import Any

import numpy as np
from kernels import CALLS, M, least, native

from cdpr.model.address import address, caller
from cdpr.model.jit import kernel
from cdpr.model.kinds import ROW, TABLE, WHOLE
from cdpr.native.operations import target

SOLVE = WHOLE(TABLE, ROW, ROW, ROW, ROW, ROW, TABLE)
solve = caller(SOLVE)

# Module, numbers of numba, and of the library.
ONES = np.ones(M)
SOLVERS: dict[str, tuple[str, Any, dict[str, Any]]] = {
    "dykstra": ("dykstra", [500, 1e-12], {"iterations": 500, "tolerance": 1e-12}),
    "improved_closed_form": ("improved_closed_form", [0.0], {"scaled": 0}),
    "puncture": ("puncture", [], {}),
    "improved_puncture": ("improved_puncture", [0.0], {}),
    "kernel_method": ("kernel_method", [], {}),
    "p_norm": ("p_norm", [4.0], {"p": 4}),
    "centroid": ("centroid", [], {}),
    "minimum_sum": ("lp", ONES, {"weights": ONES}),
    "minimum_largest": ("infinity_norm", [], {}),
    "maximin": ("maximin", [1.0], {"ball": 1}),
    "analytic_centre": ("analytic_centre", ONES, {"weights": ONES}),
}


@kernel
def repeat(
    place: float,
    W: Any,
    wrench: Any,
    low: Any,
    high: Any,
    tension: Any,
    parameters: Any,
    work: Any,
    calls: int,
) -> None:
    """Run a solver of numba by its address."""
    for _ in range(calls):
        solve(place, W, wrench, low, high, tension, parameters, work)


def main() -> None:
    """Print a line for each solver and wrench."""
    rng = np.random.default_rng(1)
    print(f"instruction set {target()}")
    low, high, tension = np.full(M, 20.0), np.full(M, 400.0), np.empty(M)
    work = np.empty((8 * M + 40, 4 * M))
    for name in sys.argv[1:] or SOLVERS:
        module, numbers, options = SOLVERS[name]
        place = address(getattr(import_module(f"cdpr_solvers.{module}"), name), SOLVE)
        W = rng.normal(size=(7 if name == "kernel_method" else 6, M))
        if name == "kernel_method":
            W[:, -1] = -W[:, :-1] @ rng.uniform(0.5, 2.0, M - 1)
        parameters = np.array(numbers, dtype=np.float64)
        for label, spread in (("inside", 60.0), ("at limits", 185.0)):
            problem = {"matrix": W, "wrench": W @ (210.0 + spread * rng.uniform(-1.0, 1.0, M))}
            problem |= {"tension_min": low, "tension_max": high}
            wrench = problem["wrench"]
            run = lambda: repeat(place, W, wrench, low, high, tension, parameters, work, CALLS)  # noqa: B023, E731
            given = problem | {key: value for key, value in options.items() if isinstance(value, np.ndarray)}
            ours = {key: value for key, value in options.items() if key not in given}
            numba, one = least(run, native(name, given | ours, {"tension": (M,), "status": (1,)}))
            times = f"numba {1e9 * numba:8.1f} ns, native {1e9 * one:8.1f} ns"
            print(f"{name + ', ' + label:32} {times}; ratio {one / numba:.2f}", flush=True)


if __name__ == "__main__":
    main()
