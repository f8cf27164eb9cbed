"""Built-in tension solvers."""

from __future__ import annotations

from cdpr.plugins import PluginInfo, hookimpl
from cdpr_solvers.options import (
    AnalyticCentreOptions,
    ClarabelOptions,
    DaqpOptions,
    DykstraOptions,
    ExactOptions,
    HighsOptions,
    ImprovedClosedFormOptions,
    LpOptions,
    MaximinOptions,
    OsqpOptions,
    PiqpOptions,
    PNormOptions,
    QpOptions,
    QpsolversOptions,
)

# Properties of most solvers: exact for any number of cables within the limits, after a bounded number of steps.
EXACT = {
    "exact": True,
    "max_redundancy": "any",
    "coverage": "full",
    "respects_bounds": True,
    "bounded_time": True,
    "warm_start": False,
    "platform_independent": True,
}

NORM = "min |t|^2, W t = wrench, t_min <= t <= t_max"


@hookimpl
def cdpr_solvers() -> list[PluginInfo]:
    """Return the built-in solvers."""
    return [*null_space_solvers(), *classical_solvers(), *library_solvers()]


def null_space_solvers() -> list[PluginInfo]:
    """Return the solvers based on the null space and active sets of the kernel library."""
    return [
        PluginInfo(
            name="qp",
            factory="cdpr_solvers.qp:MinimumNorm",
            summary="minimum 2-norm of the tensions, within the limits; exact",
            properties={
                **EXACT,
                "objective": "min_norm",
                "continuity": "C0",
                "formula": "min sum w_i (t_i - ref_i)^2",
                "source": "Bruckmann et al. 2006; Goldfarb and Idnani 1983",
            },
            options=QpOptions,
            aliases={"2-norm": "Gouttefarde et al. 2015"},
        ),
        PluginInfo(
            name="lp",
            factory="cdpr_solvers.lp:MinimumSum",
            summary="minimum sum of the tensions (1-norm), within the limits (thesis 6.24); exact; tensions can jump",
            properties={
                **EXACT,
                "objective": "one_norm",
                "continuity": "jump",
                "formula": "min sum w_i t_i; of several optima that of least 2-norm",
                "source": "thesis 6.24; parametric active set, Mangasarian and Meyer 1979",
            },
            options=LpOptions,
            aliases={"1-norm": "Gouttefarde et al. 2015"},
        ),
        PluginInfo(
            name="infinity_norm",
            factory="cdpr_solvers.infinity_norm:MinimumLargest",
            summary="minimum of the largest tension (infinity norm), within the limits; exact; tensions can jump",
            properties={
                **EXACT,
                "objective": "infinity_norm",
                "continuity": "jump",
                "formula": "min max |t_i|; of several optima that of least 2-norm",
                "source": "Gouttefarde et al. 2015; parametric active set, Mangasarian and Meyer 1979",
            },
            aliases={"infinity-norm": "Gouttefarde et al. 2015"},
        ),
        PluginInfo(
            name="maximin",
            factory="cdpr_solvers.maximin:Maximin",
            summary="tensions as far as possible from all limits; `norm` selects the distance; tensions can jump",
            properties={
                **EXACT,
                "objective": "max_slack",
                "continuity": "jump",
                "formula": "max s : t_min + s d <= t <= t_max - s d",
                "source": "Borgstrom et al. 2009",
            },
            options=MaximinOptions,
        ),
        PluginInfo(
            name="analytic_centre",
            factory="cdpr_solvers.analytic_centre:AnalyticCentre",
            summary="tensions away from all limits (analytic centre); smooth in wrench and pose",
            properties={
                **EXACT,
                "objective": "analytic_centre",
                "continuity": "Cinf",
                "formula": "min -sum w_i [log(t_i - t_min,i) + log(t_max,i - t_i)]",
                "source": "Boyd and Vandenberghe 2004, 8.5.3; for cables arXiv:2505.07348 (weights and stiffness), and "
                "Experimental validation of the analytic-centre based tension distribution algorithm for cable driven "
                "parallel robots, 2025",
            },
            options=AnalyticCentreOptions,
        ),
        PluginInfo(
            name="centroid",
            factory="cdpr_solvers.centroid:Centroid",
            summary="centroid of the set of admissible tensions, for at most two redundant cables",
            properties={
                **EXACT,
                "objective": "centroid",
                "max_redundancy": 2,
                "continuity": "C0",
                "formula": "mean of { t : W t = w, t_min <= t <= t_max }",
                "source": "Mikelsons et al. 2008, Gouttefarde et al. 2015",
            },
            aliases={
                "barycentre": "Mikelsons et al. 2008",
                "barycenter": "Mikelsons et al. 2008",
                "turn-around": "Gouttefarde et al. 2015, who walk around the polygon",
            },
        ),
        PluginInfo(
            name="best_effort",
            factory="cdpr_solvers.best_effort:BestEffort",
            summary="as `qp`; for an infeasible wrench, tensions within the limits that produce the nearest wrench",
            properties={
                **EXACT,
                "objective": "min_norm",
                "continuity": "C0",
                "formula": "min |D (W t - w)|, then min |t|^2",
                "source": "Stark and Parker 1995 (BVLS), Cote et al. 2016",
            },
        ),
        PluginInfo(
            name="pseudo_inverse",
            factory="cdpr_solvers.pseudo_inverse:PseudoInverse",
            summary="minimum 2-norm without limits (thesis 6.26); by default, cdpr clips the tensions to the limits",
            properties={
                **EXACT,
                "objective": "min_norm",
                "coverage": "partial",
                "respects_bounds": False,
                "continuity": "Cinf",
                "formula": "t = W^+ w",
                "source": "thesis 6.26",
            },
        ),
        PluginInfo(
            name="closed_form",
            factory="cdpr_solvers.closed_form:ClosedForm",
            summary="tensions closest to the middle of the limits (thesis 6.28, corrected); fails if one "
            "violates a limit",
            properties={
                **EXACT,
                "objective": "mid_range",
                "coverage": "partial",
                "continuity": "Cinf",
                "formula": "t = t_m + W^+ (w - W t_m)",
                "source": "Pott, Bruckmann and Mikelsons 2009; thesis 6.28 corrected",
            },
        ),
    ]


def library_solvers() -> list[PluginInfo]:
    """Return the solvers of optimisation libraries, and the exact solver for their verification."""
    return [
        PluginInfo(
            name="osqp",
            factory="cdpr_solvers.osqp:Osqp",
            summary="minimum 2-norm within the limits, by the library OSQP, to about 1e-5 N",
            requires=("osqp", "scipy"),
            extra="cdpr[solvers]",
            properties={
                "objective": "min_norm",
                "formula": NORM,
                "source": "Stellato et al. 2020, with polishing",
                **EXACT,
                "exact": False,
                "coverage": "partial",  # gives up if it converges too slowly
                "continuity": "C0",
                "warm_start": True,  # only for its step size and scaling
            },
            options=OsqpOptions,
        ),
        PluginInfo(
            name="daqp",
            factory="cdpr_solvers.daqp:Daqp",
            summary="minimum 2-norm within the limits, by the library DAQP; exact",
            requires=("daqp",),
            extra="cdpr[solvers]",
            properties={
                "objective": "min_norm",
                "formula": NORM,
                "source": "Arnström, Bemporad and Axehill 2022",
                **EXACT,
                "continuity": "C0",
            },
            options=DaqpOptions,
        ),
        PluginInfo(
            name="piqp",
            factory="cdpr_solvers.piqp:Piqp",
            summary="minimum 2-norm within the limits, by the library PIQP, to about 1e-5 N",
            requires=("piqp",),
            extra="cdpr[solvers]",
            properties={
                "objective": "min_norm",
                "formula": NORM,
                "source": "Schwan, Jiang, Kuhn and Jones 2023",
                **EXACT,
                "exact": False,
                "continuity": "C0",
            },
            options=PiqpOptions,
        ),
        PluginInfo(
            name="clarabel",
            factory="cdpr_solvers.clarabel:Clarabel",
            summary="minimum 2-norm within the limits, by the library Clarabel, to about 1e-6 N",
            requires=("clarabel", "scipy"),
            extra="cdpr[solvers]",
            properties={
                "objective": "min_norm",
                "formula": NORM,
                "source": "Goulart and Chen 2024",
                **EXACT,
                "exact": False,
                "continuity": "C0",
            },
            options=ClarabelOptions,
        ),
        PluginInfo(
            name="highs",
            factory="cdpr_solvers.highs:Highs",
            summary="minimum sum of the tensions, within the limits, by the library HiGHS; exact; tensions can jump",
            requires=("highspy",),
            extra="cdpr[solvers]",
            properties={
                "objective": "one_norm",
                "formula": "min sum t, W t = wrench, t_min <= t <= t_max",
                "source": "thesis 6.24; Huangfu and Hall 2018, dual simplex",
                **EXACT,
                "continuity": "jump",
            },
            options=HighsOptions,
        ),
        PluginInfo(
            name="qpsolvers",
            factory="cdpr_solvers.qpsolvers:Qpsolvers",
            summary="minimum 2-norm within the limits, by an installed solver of the package qpsolvers",
            requires=("qpsolvers",),  # LGPL, so not in an extra
            properties={  # for the default solver
                "objective": "min_norm",
                "formula": NORM,
                "source": "Caron et al., qpsolvers; by default as daqp",
                **EXACT,
                "continuity": "C0",
            },
            options=QpsolversOptions,
        ),
        PluginInfo(
            name="exact",
            factory="cdpr_solvers.exact:Exact",
            summary="minimum 2-norm or sum within the limits, in rational arithmetic; slow, to verify other solvers",
            properties={  # for the default objective
                "objective": "min_norm",
                "formula": NORM,
                "source": "Goldfarb and Idnani 1983 over the rational numbers; the sum: Ferris 1991",
                **EXACT,
                "continuity": "C0",
                "slow": True,
            },
            options=ExactOptions,
        ),
    ]


def classical_solvers() -> list[PluginInfo]:
    """Return the closed forms and iterations of the literature, which miss some feasible wrenches."""
    partial = {**EXACT, "coverage": "partial"}
    return [
        PluginInfo(
            name="improved_closed_form",
            factory="cdpr_solvers.improved_closed_form:ImprovedClosedForm",
            summary="closed_form, violating tensions set to limits (thesis 6.30-6.32); misses a few feasible wrenches",
            properties={
                "formula": "t_m + W^+ (w - W t_m); the worst cable to its limit, the others again, m - n times at most",
                "source": "Pott 2013; thesis 6.30-6.32",
                **partial,
                # No objective: if too many cables are fixed and the result is feasible, it is not the nearest to the
                # middle.
                "continuity": "jump",
            },
            options=ImprovedClosedFormOptions,
        ),
        PluginInfo(
            name="puncture",
            factory="cdpr_solvers.puncture:Puncture",
            summary="moves from pseudo_inverse towards closed_form until all tensions are within the limits",
            properties={
                "formula": "t_0 + s (t_c - t_0), the least s in [0, 1] within the limits",
                "source": "Müller, Reichert and Bruckmann 2015",
                **partial,
                "continuity": "C0",
            },
        ),
        PluginInfo(
            name="improved_puncture",
            factory="cdpr_solvers.improved_puncture:ImprovedPuncture",
            summary="moves from pseudo_inverse towards improved_closed_form until all tensions are within the limits",
            properties={
                "formula": "t_0 + s (t_c - t_0), t_c the improved closed form, the least s in [0, 1] within the limits",
                "source": "Müller, Reichert and Bruckmann 2015 with Pott 2013, as CASPR's id_cf_ipm",
                **partial,
                "continuity": "jump",
            },
        ),
        PluginInfo(
            name="kernel",
            factory="cdpr_solvers.kernel_method:KernelMethod",
            summary="pseudo-inverse plus a positive vector of the null space (thesis 6.33-6.35, corrected); "
            "one redundant cable",
            properties={
                "formula": "t_0 + max((t_min,i - t_0,i) / h_i) h, W h = 0, h > 0",
                "source": "thesis 6.33-6.35 corrected",
                **partial,
                "max_redundancy": 1,
                "continuity": "C0",
            },
        ),
        PluginInfo(
            name="dykstra",
            factory="cdpr_solvers.dykstra:Dykstra",
            summary="tensions nearest to the middle of the limits, by at most `iterations` alternating projections",
            properties={
                "objective": "mid_range",
                "formula": "min |t - t_m|^2, by projections on W t = w and on the limits in turn",
                "source": "Hassan and Khajepour 2011; Boyle and Dykstra 1986",
                **partial,
                "continuity": "C0",
            },
            options=DykstraOptions,
        ),
        PluginInfo(
            name="p_norm",
            factory="cdpr_solvers.p_norm:PNorm",
            summary="minimum p-norm of the distances from the middle of the limits; fails if a tension "
            "violates a limit",
            properties={
                "objective": "p_norm",
                "formula": "min sum |(t_i - t_m,i) / h_i|^p, h half ranges",
                "source": "Gosselin and Grenier 2011",
                **partial,
                "continuity": "C0",
            },
            options=PNormOptions,
        ),
    ]
