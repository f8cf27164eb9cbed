// Distribution closest to the middle of the limits. SPDX-License-Identifier: Apache-2.0
//
// t = t_mid + W^+ (wrench - W t_mid): Pott, Bruckmann and Mikelsons (2009); thesis, equation 6.28, corrected. See the
// docstring of the module.
#pragma once

#include <cdpr/tension/distribute.hpp>
#include <cdpr_solvers/projection.hpp>

namespace cdpr::CDPR_TARGET {

struct ClosedForm {
    template <class T> static CDPR_INLINE T choose(const TensionProblem<T>& problem, int64_t r) {
        const T status = nearest_to_middle(problem, r);
        const Truth<T> found = status == T(double(OK));
        return any(found) ? select(found, admitted(problem, r), status) : status;
    }
};

template <class T> inline int closed_form(TensionProblem<T>& problem) { return distribute<ClosedForm>(problem); }

}  // namespace cdpr::CDPR_TARGET
