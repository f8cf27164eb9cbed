"""Logged values that are not finite end a run as diverged."""

from __future__ import annotations

import numpy as np
import pytest

import cdpr
from cdpr.base.column import Column
from cdpr.base.columns import ELECTRICAL, INNOVATION, MOTORS, NEED_NOT_BE_FINITE, NOMINAL_COLUMNS, STEPPERS, UNCERTAINTY
from cdpr.base.errors import Diverged, ExitCode
from cdpr.log.finite import Finite
from cdpr.log.layout import Layout
from cdpr_backends.reference_euler import SemiImplicitEuler
from cdpr_controllers import StaticOptions
from cdpr_controllers.static import Static


class InfiniteWork(SemiImplicitEuler):
    """Its cables' work is infinite from 0.05 s on; state and tensions stay sound."""

    properties = {"cable_models": ["ideal", "elastic"], "exits": ["point", "pulley"]}  # noqa: RUF012

    def readings(self, tension, work):
        return None

    def reset(self, state):
        self.time = 0.0
        super().reset(state)

    def step(self, n):
        self.time += n * self.physics_step
        super().step(n)

    def cable_work(self):
        return np.inf if self.time > 0.0495 else super().cable_work()


class LogsEffort(Static):
    """Writes a column of its own, NaN at first and then `value`."""

    Options = StaticOptions
    columns = (Column("effort", 1, "N", "Effort"),)
    value = np.inf

    def log(self, columns):
        self.effort = columns["effort"]

    def control(self, time, state, desired, out):
        super().control(time, state, desired, out)
        if time > 0.0195:
            self.effort[0] = self.value


class LogsNan(LogsEffort):
    value = np.nan


def told(**arguments):
    with pytest.raises(Diverged) as told:
        cdpr.simulate(**arguments)
    assert told.value.exit_code == ExitCode.DIVERGED
    assert told.value.run.status == "diverged"
    return str(told.value)


def winched(duration):
    return {"scenario": "winch", "backend": InfiniteWork, "overrides": {"simulation.duration": duration}}


@pytest.mark.parametrize("duration", [0.1, 0.4])  # less than a block of samples, and more
def test_infinite_work_of_a_backend(duration, tmp_path):
    text = told(**winched(duration), out=tmp_path / "run")
    assert "the logged value 'cable_work' is inf at t = 0.05 s; expected a finite number" in text


def test_infinite_column_of_a_controller():
    overrides = {"simulation.duration": 0.05}
    text = told(scenario="caroca", controller=LogsEffort, overrides=overrides)
    assert "the logged value 'effort' of the controller is inf at t = 0.02 s" in text
    assert cdpr.simulate("caroca", controller=LogsNan, overrides=overrides).status == "finished"


def test_rollouts_report_it_too():
    found = cdpr.rollout(
        "caroca",
        1,
        vary={"controller.kp": [100.0]},
        controller=LogsEffort,
        overrides={"simulation.duration": 0.05},
        columns=["position", "effort"],
        threads=1,
    )
    assert found.status.tolist() == ["diverged"]


def test_rows_of_a_ring_are_checked_once_and_again_after_a_rewind():
    layout = Layout(8)
    rows = np.zeros((4, layout.width))
    finite = Finite(layout, 0.5)
    finite.take(rows, 4)
    rows[1, layout.columns["kinetic"]] = np.nan
    finite.take(rows, 5)  # only row 0 is new
    assert not finite.fault
    finite.take(rows, 6)
    assert "'kinetic' is nan at t = 2.5 s" in finite.fault
    finite.rewind(5)
    assert not finite.fault


def test_margins_need_not_be_finite_and_other_columns_must_be():
    layout = Layout(2, (*NOMINAL_COLUMNS, *MOTORS, *ELECTRICAL, *STEPPERS, *UNCERTAINTY, *INNOVATION))
    assert set(layout.fields) > NEED_NOT_BE_FINITE
    for name in layout.fields:
        for value in (np.nan, np.inf, -np.inf):
            rows = np.zeros((1, layout.width))
            rows[0, layout.columns[name]] = value
            finite = Finite(layout, 1.0)
            finite.take(rows, 1)
            assert bool(finite.fault) == (name not in NEED_NOT_BE_FINITE), name
