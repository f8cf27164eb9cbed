"""Several changes of the attached bodies at one sample: a saved session, which makes one change, has the same bits."""

from __future__ import annotations

import pytest
from plants import installed

import cdpr

SHORT = {"simulation.duration": 0.06}
CENTER = [0.1, 0.05, -0.3]
EARLY = {"type": "payload", "time": 0.01, "duration": 0.01, "mass": 4.0, "center": [0.0, 0.1, 0.2]}
LATE = {**EARLY, "time": 0.02}
BACKENDS = installed("reference", "mujoco", "bullet", "dart")


def saved_run(sim, tmp_path):
    """Return the rows of the session, and those of its saved scenario."""
    sim.step(100)
    sim.save(tmp_path / "session.yaml")
    return sim.run().rows.tobytes(), cdpr.simulate(tmp_path / "session.yaml").rows.tobytes()


@pytest.mark.parametrize("scenario", ["caroca", "winch", "planar"])
@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.usual("caroca-reference", "reference-caroca", "mujoco-winch", "reference-winch")
def test_a_body_released_at_its_sample_was_never_there(scenario, backend, tmp_path):
    overrides = {**SHORT, "simulation.backend": backend, "events": [EARLY]}
    plain = cdpr.simulate(scenario, overrides=overrides).rows.tobytes()
    with cdpr.Simulation(scenario, overrides=overrides) as sim:
        for k in (3, 10, 7, 1):
            sim.step(k)
            bodies = [sim.attach(mass, CENTER, known=known) for mass, known in ((30.0, True), (2.0, False))]
            push = sim.push([1.0, 0.0, 0.0])
            sim.release(bodies[0])
            sim.release(push)
            sim.release(bodies[1])
            assert sim.events == sim.scenario.events
        assert saved_run(sim, tmp_path) == (plain, plain)


@pytest.mark.parametrize("scenario", ["caroca", "winch"])
def test_a_body_attached_with_one_of_the_scenario(scenario, tmp_path):
    """Live, the platform takes one after the other; in the saved scenario both at once."""
    with cdpr.Simulation(scenario, overrides={**SHORT, "events": [EARLY, LATE]}) as sim:
        for k in (10, 10):
            sim.step(k)
            wrong = sim.attach(8.0, CENTER)
            sim.attach(30.0, CENTER, duration=0.005)
            sim.release(wrong)
        rows, again = saved_run(sim, tmp_path)
    assert rows == again


def test_a_push_that_stays_acts_on_the_restored_plant(tmp_path):
    with cdpr.Simulation("caroca", overrides={**SHORT, "events": [EARLY]}) as sim:
        sim.step(5)
        body = sim.attach(30.0)
        sim.push([100.0, 0.0, 0.0])
        sim.release(body)
        rows, again = saved_run(sim, tmp_path)
    assert rows == again


@pytest.mark.parametrize("scenario", ["caroca", "winch"])
def test_a_snapshot_between_attach_and_release(scenario, tmp_path):
    plain = cdpr.simulate(scenario, overrides={**SHORT, "events": [EARLY]}).rows.tobytes()
    with cdpr.Simulation(scenario, overrides={**SHORT, "events": [EARLY]}) as sim:
        sim.step(10)
        body = sim.attach(30.0, CENTER)
        within = sim.snapshot()
        sim.release(body)
        sim.step(4)
        sim.attach(1.0)
        sim.restore(within)
        sim.release(body)
        assert saved_run(sim, tmp_path) == (plain, plain)


def test_requests_release_a_body_at_its_sample():
    from cdpr.simulation.driver import Driver
    from cdpr.simulation.requests import Request

    with cdpr.Simulation("caroca", overrides=SHORT) as sim:
        driver = Driver(sim)
        driver.perform(Request("attach", {"mass": 30.0}))
        ((key, _),) = driver.acting()
        driver.perform(Request("release", {"id": key}))
        assert (list(driver.acting()), sim.events) == ([], ())
