// Backends: bodies, guides and the integrators of the reference. SPDX-License-Identifier: Apache-2.0
#include <cdpr/group.hpp>
#include <cdpr/mechanics/body_frame.hpp>
#include <cdpr/mechanics/guide.hpp>
#include <cdpr_backends/reference.hpp>
#include <cdpr_backends/reference_euler.hpp>
#include <cdpr_backends/reference_friction.hpp>
#include <cdpr_backends/reference_guided.hpp>
#include <cdpr_backends/reference_spherical.hpp>

namespace cdpr::CDPR_TARGET {

static constexpr cdpr_entry entries[] = {
    entry<BodyState<double>, body_state<double>>("body_state"),
    entry<PlatformState<double>, platform_state<double>>("platform_state"),
    entry<AppliedWrench<double>, applied_wrench<double>>("applied_wrench"),
    entry<GuideState<double>, guide_state<double>>("guide_state"),
    entry<GuideForces<double>, guide_forces<double>>("guide_forces"),
    entry<ReferenceBegin<double>, reference_begin<double>>("reference_begin"),
    entry<ReferenceStep<double>, reference_step<double>>("reference_step"),
    entry<FrictionStep<double>, friction_step<double>>("friction_step"),
    entry<ExitTensions<double>, exit_tensions<double>>("exit_tensions"),
    entry<GuidedStep<double>, guided_step<double>>("guided_step"),
    entry<SphericalBegin<double>, spherical_begin<double>>("spherical_begin"),
    entry<SphericalStep<double>, spherical_step<double>>("spherical_step"),
    entry<EulerFreeStep<double>, euler_free_step<double>>("euler_free_step"),
    entry<EulerGuidedStep<double>, euler_guided_step<double>>("euler_guided_step"),
    entry<EulerSphericalStep<double>, euler_spherical_step<double>>("euler_spherical_step"),
#ifndef CDPR_ALONE
    entry<PlatformState<Lanes>, platform_state<Lanes>>("platform_state_lanes"),
    entry<AppliedWrench<Lanes>, applied_wrench<Lanes>>("applied_wrench_lanes"),
    entry<ReferenceStep<Lanes>, reference_step<Lanes>>("reference_step_lanes"),
    entry<FrictionStep<Lanes>, friction_step<Lanes>>("friction_step_lanes"),
    entry<ExitTensions<Lanes>, exit_tensions<Lanes>>("exit_tensions_lanes"),
    entry<GuidedStep<Lanes>, guided_step<Lanes>>("guided_step_lanes"),
    entry<SphericalStep<Lanes>, spherical_step<Lanes>>("spherical_step_lanes"),
    entry<EulerFreeStep<Lanes>, euler_free_step<Lanes>>("euler_free_step_lanes"),
    entry<EulerGuidedStep<Lanes>, euler_guided_step<Lanes>>("euler_guided_step_lanes"),
    entry<EulerSphericalStep<Lanes>, euler_spherical_step<Lanes>>("euler_spherical_step_lanes"),
#endif
};

extern const cdpr_group backends = group(entries);

}  // namespace cdpr::CDPR_TARGET
