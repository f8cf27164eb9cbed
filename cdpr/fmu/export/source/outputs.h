// Outputs of a platform at a state, for numbers and for their derivatives. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/mechanics/platform_acceleration.hpp>

#include "model.h"

namespace fmu {

// Write the applied commands and external wrench; `moving` during a step.
void apply_inputs(const Model& model, bool moving);

// The platform and its cables, for the kernels.
cdpr::Plant<double> plant_of(const Model& model);

void publish_platform(Model& model);

// Write what the sensors of a controller measure of the winches, if it has such sensors.
void read_encoders(Model& model);
void read_load_cells(Model& model);

// Write lengths and rates of the cables and the acceleration (6) of the platform's origin, under known tensions.
template <class T> void observe(cdpr::Plant<T>& plant, T* acceleration) {
    plant_geometry(plant);
    apply(plant);
    cdpr::PlatformDynamics<T> dynamics;
    dynamics.compute(plant);
    dynamics.balanced = false;  // the derivative along the centre of mass is that of the whole mass matrix
    accelerate(plant, dynamics, acceleration);
}

}  // namespace fmu
