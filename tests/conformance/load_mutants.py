"""Backends that change the mass of their platform wrongly, each with the checks that must catch it."""

from __future__ import annotations

import numpy as np
from cdpr_traps.backend import Wrapped


class Unloaded(Wrapped):
    """A change of mass is ignored."""

    def load(self, robot):
        pass


class LoadedOnce(Wrapped):
    """Only the first change of mass has an effect."""

    loaded = False

    def load(self, robot):
        if not self.loaded:
            super().load(robot)
        self.loaded = True


class LoadedWithAJump(Wrapped):
    """A change of mass moves the platform."""

    def load(self, robot):
        super().load(robot)
        self.put(self.inner.state + np.eye(13)[2] * 1e-6)
        self.publish()


LOAD = {"load": True, "snapshot": True}
MUTANTS = {
    Unloaded: (LOAD, ["mass_changes_in_place", "guided_mass_changes_in_place"]),
    LoadedOnce: (LOAD, ["snapshot_restores_after_load"]),
    LoadedWithAJump: (LOAD, ["mass_changes_in_place", "guided_mass_changes_in_place"]),
}
