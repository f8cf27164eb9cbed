"""Bodies that are attached and released during a simulation, and are events of its session."""

from __future__ import annotations

import numpy as np
import pytest
from plants import installed

import cdpr
from cdpr.base.errors import CdprError, PluginError
from cdpr.mechanics.attachments import Attachment, with_attachments
from cdpr.simulation.driver import Driver
from cdpr.simulation.requests import Request
from cdpr.simulation.session import acting_span

SHORT = {"simulation.duration": 0.2}
CENTER, INERTIA = [0.1, 0.0, -0.3], [0.5, 0.6, 0.7, 0.1, 0.05, -0.02]
FIRST = {"type": "payload", "time": 0.01, "duration": 0.02, "mass": 4.0}


def session(tmp_path, events=(), **overrides):
    """Return the run of a session in which bodies come and go, and that of its saved scenario."""
    with cdpr.Simulation("caroca", overrides={**SHORT, "events": list(events), **overrides}) as sim:
        sim.step(50)
        body = sim.attach(30.0, CENTER, INERTIA, known=True)
        sim.step(40)
        sim.attach(5.0, duration=0.03)
        sim.step(20)
        sim.release(body)
        sim.step(90)
        sim.save(tmp_path / "session.yaml")
        run = sim.run()
    return run, cdpr.simulate(tmp_path / "session.yaml")


@pytest.mark.parametrize("backend", installed("reference", "mujoco"))
def test_the_saved_session_repeats_the_run(tmp_path, backend):
    run, again = session(tmp_path, **{"simulation.backend": backend})
    assert [(event.kind, event.time, event.until) for event in run.events] == [
        ("payload", 0.05, pytest.approx(0.11)),
        ("payload", 0.09, pytest.approx(0.12)),
    ]
    assert [event.text for event in again.events] == [event.text for event in run.events]
    assert list(again.header.layout.fields) == list(run.header.layout.fields)
    assert again.rows.tobytes() == run.rows.tobytes()
    assert again.summary()["energy_J"] == run.summary()["energy_J"]
    assert np.ptp(run.tension[:, 0]) > 10.0


def test_its_balance_is_judged_only_with_the_column_of_the_energy(tmp_path):
    run, again = session(tmp_path)
    for each in (run, again):
        energy = each.summary()["energy_J"]
        assert (energy["balanced"], energy["unknown_works"]) == (None, ["bodies taken and released"])
    text = (tmp_path / "session.yaml").read_text()
    (tmp_path / "logged.yaml").write_text(text.replace("log_energy: false", "log_energy: true"))
    logged = cdpr.simulate(tmp_path / "logged.yaml")
    assert logged.summary()["energy_J"]["balanced"] is True
    for name in run.header.layout.fields:
        assert np.array_equal(run[name], logged[name]), name
    run, again = session(tmp_path, [FIRST])
    assert run.summary()["energy_J"]["balanced"] is True
    assert run.rows.tobytes() == again.rows.tobytes()


def test_a_snapshot_is_restored_with_the_bodies_of_its_time():
    with cdpr.Simulation("caroca", overrides=SHORT) as sim:
        sim.step(20)
        before = sim.snapshot()
        body = sim.attach(30.0)
        sim.step(20)
        within = sim.snapshot()
        state = sim.state
        sim.release(body)
        sim.step(20)
        sim.restore(within)
        assert np.array_equal(sim.state, state)
        sim.release(body)
        sim.restore(before)
        assert sim.events == ()
        assert sim.so_far().header.unknown_works == []
        sim.step(180)
        assert sim.run().rows.tobytes() == cdpr.simulate("caroca", overrides=SHORT).rows.tobytes()


def without_snapshots(sim):
    """Let the plant of a simulation reject snapshots."""

    def refuse():
        raise PluginError("none")

    sim._loop.parts.backend.snapshot = refuse


def test_a_plant_without_snapshots_releases_a_body_after_a_step():
    """Otherwise the session could not be repeated to the bit: both changes round the state of the plant."""
    with cdpr.Simulation("caroca", overrides=SHORT) as sim:
        without_snapshots(sim)
        sim.step(20)
        body = sim.attach(30.0, CENTER)
        with pytest.raises(CdprError, match="release: the payload was attached at the present sample: take a step"):
            sim.release(body)
        assert sim.events == (body,)
        sim.step(1)
        sim.release(body)
        (event,) = sim.events
        assert (event.time, event.duration) == (0.02, 0.001)


class Still(cdpr.plugins.Backend):
    """Plant without `load`."""

    def reset(self, state):
        self.state[:] = state

    def step(self, n):
        pass


class Deaf(cdpr.plugins.Controller):
    """Controller that cannot take another mass."""

    def control(self, time, state, desired, out):
        out[:] = 0.0


@pytest.mark.parametrize(
    ("plugins", "keys", "error", "text"),
    [
        ({}, {"mass": -1.0}, CdprError, "attach: mass: .*greater than 0"),
        ({}, {"mass": 1.0, "center": [0, 0]}, CdprError, "attach: center: the shape must be"),
        ({}, {"mass": 1.0, "inertia": [1, 1, 5, 0, 0, 0]}, CdprError, "attach: inertia: no rigid body"),
        ({"backend": Still}, {"mass": 1.0}, PluginError, "attach: .*cannot change the mass"),
        ({"backend": "mujoco"}, {"mass": 1e12}, CdprError, "attach: .*too coarsely"),
        ({"controller": Deaf}, {"mass": 1.0, "known": True}, PluginError, "attach: .*cannot take a known mass"),
    ],
)
def test_an_impossible_body_has_no_effect(plugins, keys, error, text):
    plain = cdpr.simulate("caroca", overrides=SHORT, **plugins).rows.tobytes()
    with cdpr.Simulation("caroca", overrides=SHORT, **plugins) as sim:
        sim.step(20)
        with pytest.raises(error, match=text):
            sim.attach(**keys)
        assert sim.events == ()
        sim.step(180)
        assert sim.run().rows.tobytes() == plain


def test_requests_attach_and_release():
    with cdpr.Simulation("caroca", overrides=SHORT) as sim:
        driver = Driver(sim)
        driver.perform(Request("attach", {"mass": 30.0, "center": CENTER}))
        driver.perform(Request("push", {"force": [1.0, 0.0, 0.0]}))
        driver.perform(Request("step", {"n": 10}))
        assert sim._loop.parts.backend.robot.platform.mass == sim.scenario.robot.platform.mass + 30.0
        (key, body), (other, _) = driver.acting()
        assert acting_span(body, 1e-3).body.center.tolist() == CENTER
        driver.perform(Request("release", {"id": key}))
        assert [number for number, _ in driver.acting()] == [other]
        assert sim._loop.parts.backend.robot.platform.mass == sim.scenario.robot.platform.mass
        with pytest.raises(CdprError, match="that push has ended, or that body is released"):
            driver.perform(Request("release", {"id": key}))


def test_a_live_body_moves_the_observed_centre_of_mass():
    with cdpr.Simulation("caroca", overrides=SHORT) as sim:
        sim.attach(30.0, CENTER)
        sim.step(1)
        expected = with_attachments(sim.scenario.robot, [Attachment(30.0, np.array(CENTER), np.zeros((3, 3)))])
        assert np.array_equal(sim._loop.present._body.inertial, expected.inertial)
