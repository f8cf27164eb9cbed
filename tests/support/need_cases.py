"""Calls of all exports of a scenario, from the table of uses, for tests of the needs of sections and parts."""

from __future__ import annotations

from functools import partial

import cdpr
from cdpr.base.needs import EXPORTS
from cdpr.simulation.exported import control_of

# Options of `cdpr fmu export` by use. Python has no call for these.
FMU_OPTIONS = {"plant_fmu": [], "controller_fmu": ["--with-controller"], "bare_controller_fmu": ["--controller"]}


def exports(scenario, folder):
    """Return a call of each export that Python can call, by use; files are written into a folder."""
    calls = {
        use: partial(cdpr.export, scenario, use, folder / f"toy.{use}") for use in EXPORTS if use not in FMU_OPTIONS
    }
    return {"controller_fmu": partial(control_of, scenario), **calls}
