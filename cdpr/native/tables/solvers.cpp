// Tension solvers. SPDX-License-Identifier: Apache-2.0
#include <cdpr/group.hpp>
#include <cdpr_solvers/analytic_centre.hpp>
#include <cdpr_solvers/best_effort.hpp>
#include <cdpr_solvers/centroid.hpp>
#include <cdpr_solvers/closed_form.hpp>
#include <cdpr_solvers/dykstra.hpp>
#include <cdpr_solvers/improved_closed_form.hpp>
#include <cdpr_solvers/improved_puncture.hpp>
#include <cdpr_solvers/infinity_norm.hpp>
#include <cdpr_solvers/kernel_method.hpp>
#include <cdpr_solvers/library.hpp>
#include <cdpr_solvers/lp.hpp>
#include <cdpr_solvers/maximin.hpp>
#include <cdpr_solvers/p_norm.hpp>
#include <cdpr_solvers/pseudo_inverse.hpp>
#include <cdpr_solvers/puncture.hpp>
#include <cdpr_solvers/qp.hpp>

namespace cdpr::CDPR_TARGET {

static constexpr cdpr_entry entries[] = {
    entry<BoxLeastSquares, best_effort>("best_effort"),
    entry<TensionProblem<double>, closed_form<double>>("closed_form"),
    entry<TensionProblem<double>, pseudo_inverse<double>>("pseudo_inverse"),
    entry<Dykstra, dykstra>("dykstra"),
    entry<ImprovedClosedForm, improved_closed_form>("improved_closed_form"),
    entry<TensionProblem<double>, puncture>("puncture"),
    entry<TensionProblem<double>, improved_puncture>("improved_puncture"),
    entry<TensionProblem<double>, kernel_method>("kernel_method"),
    entry<PNorm, p_norm>("p_norm"),
    entry<Centroid, centroid>("centroid"),
    entry<Maximin, maximin>("maximin"),
    entry<MinimumSum, minimum_sum>("minimum_sum"),
    entry<MinimumLargest, minimum_largest>("minimum_largest"),
    entry<AnalyticCentre, analytic_centre>("analytic_centre"),
    entry<MinimumNorm<double>, static_cast<int (*)(MinimumNorm<double>&)>(minimum_norm)>("minimum_norm"),
    entry<LibraryProblem, library_problem>("library_problem"),
    entry<LibraryAnswer, library_answer>("library_answer"),
#ifndef CDPR_ALONE
    entry<TensionProblem<Lanes>, closed_form<Lanes>>("closed_form_lanes"),
    entry<TensionProblem<Lanes>, pseudo_inverse<Lanes>>("pseudo_inverse_lanes"),
    entry<MinimumNorm<Lanes>, static_cast<int (*)(MinimumNorm<Lanes>&)>(minimum_norm)>("minimum_norm_lanes"),
#endif
};

extern const cdpr_group solvers = group(entries);

}  // namespace cdpr::CDPR_TARGET
