"""The tension solvers that come with cdpr."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from cdpr.plugins import PluginInfo, PluginOptions, hookimpl


class ExactOptions(PluginOptions):
    """Options of the solver `exact`."""

    objective: Literal["min_norm", "one_norm"] = Field(
        "min_norm", description="what is least: the 2-norm (min_norm) or the sum of the tensions (one_norm)"
    )


class QpsolversOptions(PluginOptions):
    """Options of the solver `qpsolvers`."""

    name: str = Field("daqp", description="a solver that the library qpsolvers knows and finds installed")
    settings: dict[str, bool | int | float | str] = Field(
        default_factory=dict, description="settings of that solver, under its own names, such as eps_abs"
    )


NORM = "min |t|^2, W t = wrench, t_min <= t <= t_max"


@hookimpl
def cdpr_solvers() -> list[PluginInfo]:
    """Return the built-in solvers."""
    return [
        PluginInfo(
            name="qp",
            factory="cdpr_solvers.qp:MinimumNorm",
            summary="minimum 2-norm within the limits, exact, by a dual active set in the null space",
            properties={
                "exact": True,
                "respects_bounds": True,
                "continuity": "C0",
                "coverage": "full",
                "objective": "min_norm",
            },
        ),
        PluginInfo(
            name="pseudo_inverse",
            factory="cdpr_solvers.pseudo_inverse:PseudoInverse",
            summary="minimum 2-norm without limits (thesis 6.26); may leave them, then the stage clips",
            properties={"exact": True, "respects_bounds": False, "continuity": "Cinf"},
        ),
        PluginInfo(
            name="closed_form",
            factory="cdpr_solvers.closed_form:ClosedForm",
            summary="closest to the middle of the limits (thesis 6.28, corrected); gives up outside the limits",
            properties={"exact": True, "respects_bounds": True, "continuity": "Cinf", "objective": "mid_range"},
        ),
        PluginInfo(
            name="osqp",
            factory="cdpr_solvers.osqp:Osqp",
            summary="minimum 2-norm within the limits by OSQP, to about 1e-5 N",
            requires=("osqp", "scipy"),
            extra="cdpr[solvers]",
            properties={
                "objective": "min_norm",
                "formula": NORM,
                "source": "Stellato et al. 2020, with polishing",
                "exact": False,
                "max_redundancy": "any",
                "coverage": "partial",  # gives up where it converges too slowly
                "continuity": "C0",
                "respects_bounds": True,
                "bounded_time": True,
                "warm_start": True,  # of its step size and scaling only
            },
        ),
        PluginInfo(
            name="daqp",
            factory="cdpr_solvers.daqp:Daqp",
            summary="minimum 2-norm within the limits by DAQP, exact",
            requires=("daqp",),
            extra="cdpr[solvers]",
            properties={
                "objective": "min_norm",
                "formula": NORM,
                "source": "Arnström, Bemporad and Axehill 2022",
                "exact": True,
                "max_redundancy": "any",
                "coverage": "full",
                "continuity": "C0",
                "respects_bounds": True,
                "bounded_time": True,
                "warm_start": False,
            },
        ),
        PluginInfo(
            name="piqp",
            factory="cdpr_solvers.piqp:Piqp",
            summary="minimum 2-norm within the limits by PIQP, to about 1e-5 N",
            requires=("piqp",),
            extra="cdpr[solvers]",
            properties={
                "objective": "min_norm",
                "formula": NORM,
                "source": "Schwan, Jiang, Kuhn and Jones 2023",
                "exact": False,
                "max_redundancy": "any",
                "coverage": "full",
                "continuity": "C0",
                "respects_bounds": True,
                "bounded_time": True,
                "warm_start": False,
            },
        ),
        PluginInfo(
            name="clarabel",
            factory="cdpr_solvers.clarabel:Clarabel",
            summary="minimum 2-norm within the limits by Clarabel, to about 1e-6 N",
            requires=("clarabel", "scipy"),
            extra="cdpr[solvers]",
            properties={
                "objective": "min_norm",
                "formula": NORM,
                "source": "Goulart and Chen 2024",
                "exact": False,
                "max_redundancy": "any",
                "coverage": "full",
                "continuity": "C0",
                "respects_bounds": True,
                "bounded_time": True,
                "warm_start": False,
            },
        ),
        PluginInfo(
            name="highs",
            factory="cdpr_solvers.highs:Highs",
            summary="minimum sum of the tensions within the limits by HiGHS (thesis 6.24), exact; jumps",
            requires=("highspy",),
            extra="cdpr[solvers]",
            properties={
                "objective": "one_norm",
                "formula": "min sum t, W t = wrench, t_min <= t <= t_max",
                "source": "thesis 6.24; Huangfu and Hall 2018, dual simplex",
                "exact": True,
                "max_redundancy": "any",
                "coverage": "full",
                "continuity": "jump",
                "respects_bounds": True,
                "bounded_time": True,
                "warm_start": False,
            },
        ),
        PluginInfo(
            name="qpsolvers",
            factory="cdpr_solvers.qpsolvers:Qpsolvers",
            summary="minimum 2-norm within the limits by any solver that qpsolvers finds installed",
            requires=("qpsolvers",),  # under the LGPL, so in none of our extras
            properties={  # of the solver that it takes by default
                "objective": "min_norm",
                "formula": NORM,
                "source": "Caron et al., qpsolvers; by default as daqp",
                "exact": True,
                "max_redundancy": "any",
                "coverage": "full",
                "continuity": "C0",
                "respects_bounds": True,
                "bounded_time": True,
                "warm_start": False,
            },
            options=QpsolversOptions,
        ),
        PluginInfo(
            name="exact",
            factory="cdpr_solvers.exact:Exact",
            summary="minimum 2-norm or sum within the limits in rational arithmetic, for verification; slow",
            properties={  # of the objective that it takes by default
                "objective": "min_norm",
                "formula": NORM,
                "source": "Goldfarb and Idnani 1983 over the rational numbers; the sum: Ferris 1991",
                "exact": True,
                "max_redundancy": "any",
                "coverage": "full",
                "continuity": "C0",
                "respects_bounds": True,
                "bounded_time": True,
                "warm_start": False,
            },
            options=ExactOptions,
        ),
    ]
