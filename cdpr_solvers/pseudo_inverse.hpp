// Distribution of least 2-norm, without limits (thesis, equation 6.26). SPDX-License-Identifier: Apache-2.0
//
// t = W^+ wrench. Tensions may be negative; locked cables keep their tensions.
#pragma once

#include <cdpr/tension/distribute.hpp>

namespace cdpr::CDPR_TARGET {

struct PseudoInverse {
    template <class T> static CDPR_INLINE T choose(const TensionProblem<T>& problem, int64_t) {
        for (int64_t i = 0; i < problem.m; i++) problem.tension[i] = problem.center()[i];
        return double(OK);
    }
};

template <class T> inline int pseudo_inverse(TensionProblem<T>& problem) { return distribute<PseudoInverse>(problem); }

}  // namespace cdpr::CDPR_TARGET
