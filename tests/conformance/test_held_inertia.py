"""Engines that hold another body than the given one are refused before the first step."""

from __future__ import annotations

import numpy as np
import pytest

import cdpr
from cdpr.base.errors import PluginError
from cdpr.plugins.inertia import SINGLE_ROUND_OFF, Inertia, turned
from cdpr_backends.reference_euler import SemiImplicitEuler

SHORT = {"simulation.duration": 0.01}


class Holding(SemiImplicitEuler):
    """A sound engine that stores mass, inertia and centre of mass."""

    title = "Engine X"

    def held(self):
        frame = self.frame
        return Inertia(frame.mass, turned(frame.moments, frame.axes), frame.center)


class OtherMass(Holding):
    def held(self):
        return super().held()._replace(mass=1.001 * self.frame.mass)


class OtherInertia(Holding):
    def held(self):
        held = super().held()
        return held._replace(inertia=held.inertia + 1e-6 * np.eye(3))


class OtherCentre(Holding):
    def held(self):
        return super().held()._replace(center=self.frame.center + 1e-6)


class NoNumber(Holding):
    def held(self):
        return super().held()._replace(mass=np.nan)


class Single(Holding):
    """An engine in single precision, which declares it."""

    def held(self):
        held = super().held()
        mass = float(np.float32(self.frame.mass * (1.0 + 1e-8)))
        return held._replace(mass=mass, inertia=np.float32(held.inertia), tolerance=SINGLE_ROUND_OFF)


class Silent(Holding):
    """An engine of which nothing is read back, as of plugins that know no `held`."""

    def held(self):
        return None


@pytest.mark.parametrize(
    ("mutant", "key"),
    [(OtherMass, "mass"), (OtherInertia, "inertia"), (OtherCentre, "center_of_mass"), (NoNumber, "mass")],
)
def test_another_body_is_refused(mutant, key):
    with pytest.raises(PluginError, match=rf"^robot\.platform\.{key}: Engine X holds the .* in place of ") as told:
        cdpr.simulate("off_centre_mass", backend=mutant, overrides=SHORT)
    assert "simulation.backend: reference" in str(told.value)


@pytest.mark.parametrize("backend", [Holding, Single, Silent])
def test_the_given_body_is_accepted(backend):
    assert cdpr.simulate("off_centre_mass", backend=backend, overrides=SHORT).status == "finished"


def test_bullet_with_another_mass_is_refused():
    pybullet = pytest.importorskip("pybullet")
    from cdpr_backends.bullet.body import BulletBackend

    class Heavier(BulletBackend):
        def build(self):
            super().build()
            plant = self._plant
            pybullet.changeDynamics(plant.number, plant.link, mass=151.0, physicsClientId=plant.client)

    with pytest.raises(PluginError, match="Bullet holds the mass 151 kg in place of 150 kg"):
        cdpr.simulate("caroca", backend=Heavier, overrides=SHORT)
