"""Effects of the thesis's program that scenarios do not support: joint friction, one step per message, its fallback."""

from __future__ import annotations

from cdpr.mechanics.kinematics import wrench_matrix
from cdpr.model.robot import Array
from cdpr.plugins import Backend, TensionSolver
from cdpr.tension import Status
from cdpr.trajectory import Trajectory

# N s/m in each leg's slide and N m s in each hinge: `damping` of joints.actuated and joints.passive in its cube.yaml.
SLIDE, HINGE = 1.0, 0.01


class GazeboLegs:
    """A backend whose legs rub: against their slides, and against the platform in the hinges of its ball joints.

    With `one_step` a command acts for the first physics step alone, as in cdpr3, src/cdpr_plugin.cpp: `Update` applies
    a message once and clears its flag. The friction in the hinges at the frame, which is slower, is left out.
    """

    def __init__(self, backend: Backend, one_step: bool) -> None:
        self._backend = backend
        self._one_step = one_step

    def __getattr__(self, name: str) -> object:
        return getattr(self._backend, name)

    def step(self, n: int) -> None:
        """Advance by n physics steps, friction taken anew at the beginning of each."""
        backend = self._backend
        wanted = backend.command.copy()
        for k in range(n):
            acts = 0.0 if self._one_step and k else 1.0
            rate = -wrench_matrix(backend.robot, backend.state).T @ backend.state[7:13]
            backend.command[:] = acts * wanted + SLIDE * rate
            backend.external[3:] = -HINGE * backend.robot.m * backend.state[10:13]
            backend.step(1)
        backend.command[:] = wanted


class OrLowest:
    """A solver that puts every cable at its lower limit where it has no answer, as cdpr3's `ActivesetMethod` does.

    It returns OK and declares no limits, so that the tension stage applies its answer.
    """

    def __init__(self, solver: TensionSolver) -> None:
        self._solver = solver
        self.reset = solver.reset

    def solve(self, W: Array, wrench: Array, t_min: Array, t_max: Array, tension: Array) -> int:
        """Write the solver's answer, or the lower limits."""
        if self._solver.solve(W, wrench, t_min, t_max, tension) != Status.OK:
            tension[:] = t_min
        return Status.OK


class Playback:
    """A motion played `speed` times too fast, whose velocities and accelerations are those of the slow one."""

    def __init__(self, trajectory: Trajectory, speed: float) -> None:
        self._trajectory = trajectory
        self._speed = speed

    def sampler(self, out: Array) -> object:
        """Return a function of the time that writes the desired motion (19,)."""
        write = self._trajectory.sampler(out)
        return lambda time: write(self._speed * time)
