"""Exported cables do not push: a negative tension counts as 0, with one warning."""

from __future__ import annotations

import re

import fmpy
import numpy as np
import pytest
from conftest import ROOT
from fmu.cases import FMI, plant_of, scenario, write
from fmu.driver import Driver

from cdpr.fmu.read.archive import open_archive
from cdpr.fmu.read.options import FmuFile
from cdpr.fmu.run.running import RunningFmu
from cdpr.scenario import load_scenario

STEPS = 20
PULL = np.linspace(100.0, 300.0, 8)


def legs():
    return load_scenario(ROOT / "scenarios/caroca.yaml", overrides=["robot.unilateral=false"])


def moved(path, tension):
    with Driver(path) as driver:
        driver.set("cable_tension", tension)
        for k in range(STEPS):
            driver.step(1e-3 * k, 1e-3)
        assert driver.get("cable_tension").tolist() == list(tension)  # an input stays what the host has set
        return driver.state()


@FMI
def test_a_negative_tension_counts_as_none(fmi, tmp_path):
    path = write(plant_of(scenario("caroca")), fmi, tmp_path)
    pushed, slack = PULL.copy(), PULL.copy()
    pushed[[2, 5]], slack[[2, 5]] = [-1e-3, -500.0], 0.0
    assert moved(path, pushed).tolist() == moved(path, slack).tolist()
    assert moved(path, PULL).tolist() != moved(path, slack).tolist()


@FMI
def test_legs_push(fmi, tmp_path):
    path = write(plant_of(legs()), fmi, tmp_path)
    pushed, slack = PULL.copy(), PULL.copy()
    pushed[2], slack[2] = -500.0, 0.0
    assert moved(path, pushed).tolist() != moved(path, slack).tolist()


@FMI
@pytest.mark.parametrize("inside", [False, True], ids=["cables", "legs"])
def test_it_is_reported_once_until_none_is_negative(fmi, inside, tmp_path):
    loaded = legs() if inside else scenario("caroca")
    opened = open_archive(write(plant_of(loaded), fmi, tmp_path))
    fmu = RunningFmu(opened, "it", "plant", loaded.robot, 1e-3, FmuFile(), "inproc")
    try:
        fmu.start({})
        tension = fmu.mapping.inputs.ports["cable_tension"]
        for value in (-5.0, -5.0, -7.0, 3.0, 0.0, -0.0, -9.0, -9.0):
            tension.write(np.where(np.arange(8) == 2, value, PULL), fmu.instance.inputs)
            fmu.instance.step(1)
        said = [re.sub(r"; no further.*", "", line) for line in fmu.instance.log]
    finally:
        fmu.close()
    expected = [f"Warning: cable_tension[3] is {n} N at {t} s: a cable cannot push, so 0 N acts" for n, t in
                ((-5, "0"), (-9, "0.006"))]  # fmt: skip
    assert said == ([] if inside else expected)


@FMI
def test_the_description_contains_it(fmi, tmp_path):
    for loaded, least in ((scenario("caroca"), "0.0"), (legs(), None), (scenario("cogiro_elastic"), None)):
        about = fmpy.read_model_description(str(write(plant_of(loaded), fmi, tmp_path)))
        assert {each.min for each in about.modelVariables if each.name.startswith("cable_tension")} == {least}
        units = {each.name: each.unit for each in about.modelVariables if each.name.startswith("external")}
        assert set(units.values()) == {"N", "N.m"}
        assert all(("moment" in name) == (unit == "N.m") for name, unit in units.items())
