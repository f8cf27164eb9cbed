"""Backends with a wrong environment, each with the checks that must catch it."""

from __future__ import annotations

import numpy as np
from cdpr_traps.backend import Wrapped


class Ghost(Wrapped):
    """Obstacles are ignored."""

    def surround(self, environment):
        pass


class Attracting(Ghost):
    """Obstacles act at a distance."""

    attraction = 0.0

    def surround(self, environment):
        self.attraction = 1.0

    def loads(self):
        return self.command, self.external - self.attraction * np.eye(6)[2]


OBSTACLES = {"surroundings": ["obstacles"]}
MUTANTS = {
    Ghost: (OBSTACLES, ["obstacles_stop_the_platform"]),
    Attracting: (OBSTACLES, ["distant_obstacles_have_no_effect"]),
}
