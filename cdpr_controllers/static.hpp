// Gravity compensation with proportional and damping terms: cdpr_controllers/static.py. SPDX-License-Identifier:
// Apache-2.0
#pragma once

#include <cdpr_controllers/computed_torque.hpp>

namespace cdpr::CDPR_TARGET {

template <class T> inline int static_control(TaskSpaceControl<T>& control) {
    const T* state = control.state;
    const Feedback<T> feedback = proportional_derivative(state, control.desired, control.gains);
    store(inverse_dynamics<T>({control.inertial}, vector(control.gravity), quaternion(state + 3), no_vector<T>(),
                              feedback.linear, feedback.angular),
          control.wrench);
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
