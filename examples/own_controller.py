"""Run a scenario with a controller of your own, a proportional and damping law with gravity compensation."""

import numpy as np

import cdpr
from cdpr.model import rotations


class Spring(cdpr.plugins.Controller):
    """Controller that pulls the platform to the desired pose like a damped spring."""

    def control(self, time, state, desired, out):
        """Write the wrench (6,), N and N m, world axes."""
        mass = self.robot.platform.mass
        out[:3] = mass * (100.0 * (desired[:3] - state[:3]) + 20.0 * (desired[7:10] - state[7:10]) - self.gravity)
        turn = rotations.between(state[None, 3:7], desired[None, 3:7])[0]  # (3,) rad, world
        out[3:] = 100.0 * turn + 20.0 * (desired[10:13] - state[10:13])


run = cdpr.simulate("caroca", controller=Spring, overrides={"simulation.duration": 2.0})
print(f"{run.status}, largest position error {1000.0 * np.linalg.norm(run.position_error, axis=1).max():.1f} mm")
