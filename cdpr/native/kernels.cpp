// Table of all operations, compiled once per instruction set. SPDX-License-Identifier: Apache-2.0
//
// NAME takes doubles; NAME_lanes takes eight problems side by side (lanes.hpp).
#include <cdpr/chain.hpp>
#include <cdpr/checks.hpp>
#include <cdpr/cross_products.hpp>
#include <cdpr/entry.hpp>
#include <cdpr/geometry.hpp>
#include <cdpr/policy.hpp>
#include <cdpr/polygons.hpp>
#include <cdpr/polytope_points.hpp>
#include <cdpr/positive_definite.hpp>
#include <cdpr/rotations.hpp>
#include <cdpr/safest.hpp>
#include <cdpr_solvers/analytic_centre.hpp>
#include <cdpr_solvers/best_effort.hpp>
#include <cdpr_solvers/centroid.hpp>
#include <cdpr_solvers/closed_form.hpp>
#include <cdpr_solvers/dykstra.hpp>
#include <cdpr_solvers/improved_closed_form.hpp>
#include <cdpr_solvers/improved_puncture.hpp>
#include <cdpr_solvers/infinity_norm.hpp>
#include <cdpr_solvers/kernel_method.hpp>
#include <cdpr_solvers/lp.hpp>
#include <cdpr_solvers/maximin.hpp>
#include <cdpr_solvers/p_norm.hpp>
#include <cdpr_solvers/pseudo_inverse.hpp>
#include <cdpr_solvers/puncture.hpp>
#include <cdpr_solvers/qp.hpp>

namespace cdpr {
inline namespace CDPR_TARGET {

static constexpr cdpr_entry entries[] = {
    entry<CrossProducts<double>, cross_products<double>>("cross_products"),
    entry<Rotations<double>, rotations<double>>("rotations"),
    entry<Rotations<Lanes>, rotations<Lanes>>("rotations_lanes"),
    entry<QuaternionProducts<double>, quaternion_products<double>>("quaternion_products"),
    entry<QuaternionProducts<Lanes>, quaternion_products<Lanes>>("quaternion_products_lanes"),
    entry<RotationVectors<double>, rotation_vectors<double>>("rotation_vectors"),
    entry<RotationVectors<Lanes>, rotation_vectors<Lanes>>("rotation_vectors_lanes"),
    entry<Quaternions<double>, quaternions<double>>("quaternions"),
    entry<Quaternions<Lanes>, quaternions<Lanes>>("quaternions_lanes"),
    entry<PositiveDefinite<double>, positive_definite<double>>("positive_definite"),
    entry<PositiveDefinite<Lanes>, positive_definite<Lanes>>("positive_definite_lanes"),
    entry<Exits<double>, exits<double>>("exits"),
    entry<Exits<Lanes>, exits<Lanes>>("exits_lanes"),
    entry<ChainTensions<double>, chain_tensions<double>>("chain_tensions"),
    entry<ChainTensions<Lanes>, chain_tensions<Lanes>>("chain_tensions_lanes"),
    entry<ChainSlopes<double>, chain_slopes<double>>("chain_slopes"),
    entry<ChainSlopes<Lanes>, chain_slopes<Lanes>>("chain_slopes_lanes"),
    entry<ChainStart<double>, chain_start<double>>("chain_start"),
    entry<ChainStart<Lanes>, chain_start<Lanes>>("chain_start_lanes"),
    entry<Geometry<double>, geometry<double>>("geometry"),
    entry<Geometry<Lanes>, geometry<Lanes>>("geometry_lanes"),
    entry<MatrixRate<double>, matrix_rate<double>>("matrix_rate"),
    entry<MatrixRate<Lanes>, matrix_rate<Lanes>>("matrix_rate_lanes"),
    entry<CableWrench<double>, cable_wrench<double>>("cable_wrench"),
    entry<CableWrench<Lanes>, cable_wrench<Lanes>>("cable_wrench_lanes"),
    entry<Acceptance<double>, accept<double>>("accept"),
    entry<Acceptance<Lanes>, accept<Lanes>>("accept_lanes"),
    entry<NearestPoint, nearest_point>("nearest_point"),
    entry<ExtremePoint, extreme_point>("extreme_point"),
    entry<NearestByRows, nearest_tension_by_rows>("nearest_by_rows"),
    entry<BoxLeastSquares, box_least_squares>("box_least_squares"),
    entry<BoxLeastSquares, best_effort>("best_effort"),
    entry<Fallback, replace_tension>("replace_tension"),
    entry<MinimumNorm<double>, static_cast<int (*)(MinimumNorm<double>&)>(minimum_norm)>("minimum_norm"),
    entry<MinimumNorm<Lanes>, static_cast<int (*)(MinimumNorm<Lanes>&)>(minimum_norm)>("minimum_norm_lanes"),
    entry<TensionProblem<double>, closed_form<double>>("closed_form"),
    entry<TensionProblem<Lanes>, closed_form<Lanes>>("closed_form_lanes"),
    entry<TensionProblem<double>, pseudo_inverse<double>>("pseudo_inverse"),
    entry<TensionProblem<Lanes>, pseudo_inverse<Lanes>>("pseudo_inverse_lanes"),
    entry<Dykstra, dykstra>("dykstra"),
    entry<ImprovedClosedForm, improved_closed_form>("improved_closed_form"),
    entry<TensionProblem<double>, puncture>("puncture"),
    entry<TensionProblem<double>, improved_puncture>("improved_puncture"),
    entry<TensionProblem<double>, kernel_method>("kernel_method"),
    entry<PNorm, p_norm>("p_norm"),
    entry<AdmissibleCorners<1>, admissible_interval>("admissible_interval"),
    entry<AdmissibleCorners<2>, admissible_polygon>("admissible_polygon"),
    entry<Centroid, centroid>("centroid"),
    entry<SafestPoint, safest_points>("safest_point"),
    entry<Maximin, maximin>("maximin"),
    entry<MinimumSum, minimum_sum>("minimum_sum"),
    entry<MinimumLargest, minimum_largest>("minimum_largest"),
    entry<AnalyticCentre, analytic_centre>("analytic_centre"),
};

extern const cdpr_table table;
const cdpr_table table = {CDPR_TARGET_NAME, entries, sizeof(entries) / sizeof(entries[0])};

}  // namespace CDPR_TARGET
}  // namespace cdpr
