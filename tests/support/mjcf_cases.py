"""MJCF files imported as robots, and compiled by MuJoCo itself."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import ROOT

import cdpr
from cdpr.formats import import_file
from cdpr.formats.read.import_files import write
from cdpr.mechanics.kinematics import make_state

mujoco = pytest.importorskip("mujoco")
ROBOTS = ROOT / "scenarios" / "robots"
SAME = 1e-12  # of wrench matrices, m; kg m^2 for 1
SKY = '<texture name="sky" type="skybox" file="/nowhere.png"/>'


def taken(folder, text):
    (folder / "model.xml").write_text(text)
    return import_file(folder / "model.xml")


def robot_of(folder, text):
    return cdpr.load_robot(write(taken(folder, text), folder / "out", force=True)[0])


def compiled(text):
    """Model and data of MuJoCo itself, which wants the files that are named."""
    model = mujoco.MjModel.from_xml_string(text.replace(SKY, ""))
    return model, mujoco.MjData(model)


def random_states(count):
    rng = np.random.default_rng(15)
    for _ in range(count):
        q = rng.normal(size=4)
        yield make_state(rng.uniform(-1.0, 1.0, 3), q / np.linalg.norm(q))
