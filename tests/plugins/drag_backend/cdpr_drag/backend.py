"""A rigid body in air."""

import numpy as np

from cdpr.base.errors import PluginError
from cdpr.model import rotations
from cdpr.plugins import RigidBodyBackend

AIR = 1.2  # kg/m^3


class DragBackend(RigidBodyBackend):
    """RigidBodyBackend brings cables, external wrench and centre of mass; here a body moves under a wrench.

    `self.body` is its state at the centre of mass along the principal axes, `self.applied` the wrench, world axes.
    """

    def build(self):
        """Nothing to build: the body is the state."""
        self._work, self._column = 0.0, np.zeros(1)
        if self.frame.guide is not None:
            raise PluginError("the backend 'drag' moves free platforms only")

    def write(self):
        """Put the body into `body`, where it is already, and the clock to zero."""
        self._steps, self._work = 0, 0.0
        self._column[0] = self._work

    def log(self, columns):
        """Keep the column of the work of the drag."""
        self._column = columns["drag_work"]

    def read(self):
        """The body is in `body`."""

    def advance(self):
        """Advance by one physics step."""
        h, body, moments = self.physics_step, self.body, self.frame.moments
        velocity, omega = body[7:10], body[10:]
        drag = -0.5 * AIR * self.options.area * np.linalg.norm(velocity) * velocity
        R = rotations.matrix(body[3:7])
        spin = R.T @ omega
        spin += h * (R.T @ self.applied[3:] - np.cross(spin, moments * spin)) / moments
        velocity += h * ((self.applied[:3] + drag) / self.frame.mass + self.gravity)
        body[:3] += h * velocity
        self._work += h * (drag @ velocity)
        self._column[0] = self._work
        angle = np.linalg.norm(spin)
        if angle > 0.0:
            turn = rotations.from_axis_angle(spin / angle, h * angle)
            body[3:7] = rotations.multiply(body[3:7], turn)
            body[3:7] /= np.linalg.norm(body[3:7])
        omega[:] = R @ spin if angle == 0.0 else rotations.matrix(body[3:7]) @ spin
        self._steps += 1

    def engine_time(self):
        """Time since the reset, s."""
        return self._steps * self.physics_step

    def snapshot(self):
        """Return body, published state and clock."""
        return self.body.copy(), self.state.copy(), self._steps, self._work

    def restore(self, snapshot):
        """Go back to a snapshot."""
        self.body[:], self.state[:], self._steps, self._work = snapshot
